"""Templates: compiled once, where Python keeps what it compiles."""

import os
import subprocess
import sys

import pytest

LOAD = "from ccgen import resources; print(resources.template('library.json.j2').filename)"


def loaded(prefix, **more):
    """Load a template with a cache of its own; the compiled templates that are kept then."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment = {**kept, "PYTHONPYCACHEPREFIX": str(prefix), **more}
    found = subprocess.run(
        [sys.executable, "-c", LOAD], env=environment, capture_output=True, text=True, check=True
    )
    assert found.stdout.endswith("library.json.j2\n")
    return sorted(prefix.rglob("template-*.cache"))


def test_templates_are_compiled_once(tmp_path):
    (kept,) = loaded(tmp_path)
    first = kept.stat()
    assert loaded(tmp_path) == [kept]
    assert kept.stat().st_mtime_ns == first.st_mtime_ns


def test_nothing_is_kept_where_python_keeps_nothing(tmp_path):
    assert loaded(tmp_path, PYTHONDONTWRITEBYTECODE="1") == []


@pytest.mark.parametrize("content", [b"", b"not compiled by Jinja"])
def test_a_spoilt_one_is_compiled_anew(tmp_path, content):
    (kept,) = loaded(tmp_path)
    whole = kept.read_bytes()
    kept.write_bytes(content)
    assert loaded(tmp_path) == [kept]
    assert kept.read_bytes() == whole
