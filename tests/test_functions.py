"""A user's own functions of a joint's angles: exported in integers, verified and counted."""

import hashlib
import json
import re
import shutil
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text
from typer.testing import CliRunner

import ccgen
from ccgen.cli.main import app
from ccgen.errors import InputError
from ccgen.export.package import export
from ccgen.functions import compile_functions, read_module
from ccgen.targets.exported import Exported, open_exported
from ccgen.verify.on_core import compare_batch, run_batch
from ccgen.verify.plan import Plan, silent

ROOT = Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "examples" / "functions" / "tendons.py"
BENT = {"segments": 4, "length": 0.1, "range_of_motion": 5.0, "count": 2}
HEAD = """
import casadi
u, v = casadi.SX.sym("u", 4), casadi.SX.sym("v", 4)
"""
GOOD = HEAD + 'bend = casadi.Function("bend", [u], [casadi.sum1(u)], ["u"], ["whole"])\n'
MANY = (
    HEAD
    + """
rows = [u[k] * v[k] + k for k in range(4)] + [casadi.sumsqr(v) / 3]
names = [f"row{k}" for k in range(5)]
many = casadi.Function("many", [v, u], rows, ["v", "u"], names)
"""
)
QUICK = ["--snapshots", "20", "--values", "500"]


def finger(folder: Path, name: str = "finger", **options) -> Path:
    path = folder / f"{name}.toml"
    path.write_text(joint_text(name, **(BENT | options)))
    return path


def command(*words: str | Path):
    done = CliRunner().invoke(app, [str(word) for word in words])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


@pytest.fixture(scope="module")
def shoulder(tmp_path_factory) -> Exported:
    folder = tmp_path_factory.mktemp("functions") / "shoulder"
    joint = ROOT / "examples" / "shoulder.toml"
    assert command("export", joint, "-o", folder, "--functions", EXAMPLE).exit_code == 0
    return open_exported(folder)


def states(exported: Exported, count: int = 200) -> np.ndarray:
    """Angles over the whole format and beyond: "no reading" among them."""
    most = 2 ** (exported.model.precision - 1)
    random = np.random.default_rng(3)
    drawn = random.integers(-most, most, (count, exported.model.values))
    drawn[: count // 4] = random.choice([-most, most - 1], (count // 4, exported.model.values))
    return drawn


def held(exported: Exported, source: Path) -> None:
    """Results are within their bounds of CasADi's, in double precision, of the same angles."""
    module, values = read_module(source), states(exported)
    limit = next(iter(exported.model.axes.values())).angle_limit
    parts = exported.model.split(np.maximum(values, -limit))
    words = exported.functions.evaluate(exported.model, values)
    place = 0
    for function, compiled in zip(module.functions, exported.functions.compiled, strict=True):
        own = [exported.model.axes[name].radians(parts[name]) for name in function.name_in()]
        for row in range(len(values)):
            right = [np.array(one).ravel() for one in function.call([x[row] for x in own])]
            at = place
            for output, expected in zip(function.name_out(), right, strict=True):
                unit = Fraction(1, 2) ** compiled.formats[output]
                for value, bound in zip(expected, compiled.bounds[output], strict=True):
                    off = abs(float(int(words[row, at]) * unit) - value)
                    assert off <= float(bound) * (1 + 1e-6) + 1e-12
                    at += 1
        place = at
    assert place == words.shape[1]


def test_the_example_is_within_its_errors_of_the_exact_polynomial(shoulder):
    tendons, energy = shoulder.functions.compiled
    assert max(tendons.bounds["lengths"]) <= Fraction(1e-6)
    assert max(energy.bounds["energy"]) <= Fraction(1e-4)
    held(shoulder, EXAMPLE)


def test_the_example_equals_its_model_on_the_host_and_the_folder_needs_no_module(shoulder):
    assert not list(shoulder.directory.rglob("tendons.py"))
    done = command("verify", shoulder.directory, *QUICK, "--json")
    assert done.exit_code == 0, done.output
    runs = {run["transport"]: run for run in json.loads(done.stdout)["runs"]}
    assert runs["batch"]["compared_functions"] == 512 * 4
    assert runs["batch"]["function_mismatches"] == 0
    said = command("verify", shoulder.directory, *QUICK).stdout
    assert "functions" in said
    assert "Every angle, pose and result is the model's, bit for bit" in said


@pytest.mark.parametrize("target", ["cortex-m0", "avr"])
def test_cores_equal_the_model_and_a_wrong_checksum_is_told(shoulder, target):
    plan = Plan(values=2_000)
    printed = run_batch(shoulder, target, plan, silent)
    run = compare_batch(shoulder, target, plan, printed)
    assert (run.compared_functions, run.function_mismatches) == (64 * 4, 0)
    assert run.passed
    changed = replace(printed, functions=printed.functions ^ 1)
    run = compare_batch(shoulder, target, plan, changed)
    assert run.function_mismatches == 64 * 4
    assert not run.passed


def test_a_wrong_constant_of_a_function_is_a_mismatch(shoulder, tmp_path):
    folder = Path(shutil.copytree(shoulder.directory, tmp_path / "shoulder"))
    source = folder / "src" / "shoulder_functions.c"
    text, count = re.subn(r"INT32_C\(503316\)", "INT32_C(503317)", source.read_text())
    assert count == 1
    source.write_text(text)
    done = command("verify", folder, *QUICK, "--json")
    assert done.exit_code == 1
    batch = json.loads(done.stdout)["runs"][0]
    assert batch["function_mismatches"] > 0
    assert batch["mismatches"] == batch["pose_mismatches"] == 0
    assert (
        "results of functions differ from the model's" in command("verify", folder, *QUICK).stdout
    )


def test_the_manifest_holds_the_modules_hash_and_the_readme_its_bounds(shoulder):
    manifest = json.loads((shoulder.directory / "manifest.json").read_text())
    digest = hashlib.sha256(EXAMPLE.read_bytes()).hexdigest()
    assert manifest["inputs"]["tendons.py"] == digest
    assert shoulder.functions.sha256 == digest
    readme = (shoulder.directory / "README.md").read_text()
    assert "| `shoulder_tendons()` | u, v | `lengths`, 3 numbers | steps of 2^-22," in readme
    header = (shoulder.directory / "src" / "shoulder_functions.h").read_text()
    assert "#define SHOULDER_TENDONS_LENGTHS_BITS 22" in header
    assert "at most 8.5e-07 from the exact value" in header


@pytest.mark.parametrize("precision", [16, 32])
def test_elongation_and_both_precisions_take_part(tmp_path, precision):
    (tmp_path / "own.py").write_text(
        "import casadi\n"
        'u, h = casadi.SX.sym("u", 4), casadi.SX.sym("h", 1)\n'
        'arc = casadi.Function("arc", [h, u], [0.1 * (1 + h), (1 + h) * casadi.sum1(u)], '
        '["h", "u"], ["length", "bend"])\n'
    )
    sensors = "\n".join(
        f'[[sensor]]\nname = "s{k}"\nspan = [0, 3]\nangle = {90 * k}.0\nradius = 0.02'
        for k in range(4)
    )
    text = (
        'name = "arm"\n[geometry]\nsegments = 4\nlength = 0.1\nrange_of_motion = 5.0\n'
        f"elongation = [0.0, 0.05]\n{sensors}\n[sensors.transducer]\nbits = {precision}\n"
        f"metres_per_count = {1e-6 if precision == 16 else 1e-9}\n"
        f"[loads]\nsamples = 20\nstiffness = 0.4\nactuation = [-15.0, 15.0]\n"
        f"elongation = [0.0, 0.05]\n[fixed_point]\nprecision = {precision}\n"
    )
    (tmp_path / "arm.toml").write_text(text)
    export(tmp_path / "arm.toml", tmp_path / "arm", functions=tmp_path / "own.py")
    exported = open_exported(tmp_path / "arm")
    held(exported, tmp_path / "own.py")
    assert command("verify", tmp_path / "arm", *QUICK).exit_code == 0


def test_without_a_stated_error_it_is_a_ten_thousandth_of_the_range(tmp_path):
    (tmp_path / "own.py").write_text(GOOD)
    model = ccgen.fit(ccgen.load(finger(tmp_path))).model
    compiled = compile_functions(read_module(tmp_path / "own.py"), model).compiled[0]
    width = 2 * 4 * model.u.angle_limit * 2.0**-model.u.fraction_bits
    assert compiled.bounds["whole"][0] <= Fraction(1e-4 * width)
    (tmp_path / "fine.py").write_text(GOOD + 'errors = {"bend": {"whole": 1e-12}}\n')
    fine = compile_functions(read_module(tmp_path / "fine.py"), model).compiled[0]
    assert fine.bounds["whole"][0] <= Fraction(1e-12)


def test_cost_tells_a_call_of_each_function_apart(shoulder, tmp_path):
    done = command("cost", shoulder.directory, "--target", "cortex-m4", "--target", "avr", "--json")
    assert done.exit_code == 0, done.output
    for target in json.loads(done.stdout)["targets"]:
        own = target["functions"]
        assert list(own) == ["tendons", "bending_energy"]
        for one in own.values():
            assert 50 < one["instructions_per_call"] < 5_000
            assert one["stack_bytes"] > 0
        assert target["functions_flash_bytes"] > 500
        assert "functions" not in target["parts"]
    said = command("cost", shoulder.directory, "--target", "cortex-m4").stdout
    assert re.search(r"^target +tendons  bending_energy  flash$", said, re.MULTILINE)


@pytest.mark.parametrize("target", ["host", "cortex-m0", "riscv32"])
def test_functions_of_many_outputs_are_counted(tmp_path, target):
    (tmp_path / "own.py").write_text(MANY)
    export(finger(tmp_path), tmp_path / "out", functions=tmp_path / "own.py")
    (cost,) = ccgen.cost(tmp_path / "out", target).targets
    assert cost.times.functions["many"] > 20
    assert command("verify", tmp_path / "out", *QUICK).exit_code == 0


def test_inputs_that_a_function_leaves_alone_are_no_warnings(tmp_path):
    source = tmp_path / "few.py"
    source.write_text(
        HEAD
        + """
few = casadi.Function("few", [u, v], [u[1] * v[2], u[3]], ["u", "v"], ["product", "same"])
near = casadi.Function("near", [u, v], [u[0] * u[1]], ["u", "v"], ["product"])
fixed = casadi.Function("fixed", [u], [casadi.SX(0.25)], ["u"], ["quarter"])
"""
    )
    folder = tmp_path / "firmware"
    assert command("export", finger(tmp_path), "-o", folder, "--functions", source).exit_code == 0
    done = command("verify", folder, "--target", "host", *QUICK)
    assert done.exit_code == 0, done.output


def test_what_a_module_prints_stays_out_of_json_and_its_neighbours_can_be_imported(tmp_path):
    (tmp_path / "radius_of_mine.py").write_text("R = 0.02\n")
    (tmp_path / "own.py").write_text(
        'from radius_of_mine import R\nprint("hello")\n_hidden = None\n'
        + GOOD.replace("[casadi.sum1(u)]", "[R * casadi.sum1(u)]")
        + "alias = bend\n"
    )
    done = command(
        "export", finger(tmp_path), "-o", tmp_path / "out", "--functions", tmp_path / "own.py",
        "--json",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert "src/finger_functions.c" in json.loads(done.stdout)["files"]
    assert "hello" in done.stderr
    assert len(open_exported(tmp_path / "out").functions.compiled) == 1
    assert not (tmp_path / "out" / "src" / "own.py").exists()


def function_of(body: str, inputs: str = '[u, v], ["u", "v"]') -> str:
    given, names = inputs.split("], ")
    return HEAD + f'f = casadi.Function("f", {given}], [{body}], {names}, ["out"])\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (function_of("casadi.sin(u)"), "own.py: f: uses sin, which no polynomial has"),
        (function_of("casadi.sqrt(u[0])"), "own.py: f: uses sqrt, which no polynomial has"),
        (function_of("u / v"), "own.py: f: divides by a variable, which no polynomial does"),
        (function_of("casadi.if_else(u[0] > 0, 1, 2)"), "own.py: f: uses a branch"),
        (
            function_of("u", '[u], ["w"]'),
            "own.py: f: the input w is none of the joint's: u (4 angles), v (4 angles)",
        ),
        (
            function_of("u", '[u], ["h"]'),
            "own.py: f: the input h is none of the joint's: u (4 angles), v (4 angles)",
        ),
        (
            function_of("u", '[u[:3]], ["u"]').replace("[u[:3]]", '[casadi.SX.sym("u", 3)]', 1)
            .replace("[u]", "[1]"),
            "own.py: f: the input u has 3 x 1 elements; the joint has u (4 angles), v (4 angles)",
        ),
        (
            function_of("1e3 * u[0] * u[1] * v[0]") + 'errors = {"f": 1e-9}\n',
            "own.py: f: no plan of 32 bits meets the error; the best is proven to ",
        ),
        ("import no_such_thing\n", "own.py:1: ModuleNotFoundError: No module named"),
        ("import casadi\nx = 1 / 0\n", "own.py:2: ZeroDivisionError: division by zero"),
        ("import casadi\nx = (\n", "own.py:2: SyntaxError: '(' was never closed"),
        ("raise SystemExit\n", "own.py:1: SystemExit"),
        ("x = 1\n", "own.py: defines no casadi.Function at module level"),
        (GOOD + "errors = 1\n", 'own.py: errors: is no dict; write errors = {"bend": 1e-5}'),
        (GOOD + 'errors = {"bent": 1}\n', "own.py: errors: 'bent' is no function of the module"),
        (
            GOOD + 'errors = {"bend": {"half": 1}}\n',
            "own.py: errors: bend: 'half' is no output; it has whole",
        ),
        (GOOD + 'errors = {"bend": 0}\n', "own.py: errors: bend: 0 is no error; write a number"),
        (GOOD + 'errors = {"bend": "x"}\n', "own.py: errors: bend: 'x' is no error"),
        (
            GOOD.replace('"bend"', '"estimate"'),
            "own.py: src/finger.h has finger_estimate already; rename the function",
        ),
        (
            GOOD.replace('["whole"]', '["angles"]'),
            "own.py: bend: an output is called angles, as the joint's angles are; rename it",
        ),
        (GOOD.replace('["whole"]', '["t1"]'), "own.py: t1 cannot be a name in C; rename it"),
        (
            GOOD + 'other = casadi.Function("bend", [v], [v], ["v"], ["whole"])\n',
            "own.py: two functions are called bend; rename one",
        ),
    ],
)  # fmt: skip
def test_a_module_that_cannot_be_exported_is_one_line_and_nothing_is_written(tmp_path, text, said):
    (tmp_path / "own.py").write_text(text)
    done = command(
        "export", finger(tmp_path), "-o", tmp_path / "out", "--functions", tmp_path / "own.py"
    )
    assert done.exit_code == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["finger.toml", "own.py"]


def test_a_module_that_is_not_there_is_named(tmp_path):
    done = command(
        "export", finger(tmp_path), "-o", tmp_path / "out", "--functions", tmp_path / "own.py"
    )
    assert done.exit_code == 2
    assert "own.py: No such file or directory; name a Python file" in done.stderr


def test_a_function_that_calls_another_is_expanded(tmp_path):
    (tmp_path / "own.py").write_text(
        HEAD
        + '_square = casadi.Function("square", [u], [u * u])\n'
        + 'x = casadi.MX.sym("u", 4)\n'
        + 'f = casadi.Function("f", [x], [_square(x)[0] / 2], ["u"], ["out"])\n'
    )
    fit = ccgen.fit(ccgen.load(finger(tmp_path)))
    ccgen.export(fit, tmp_path / "out", functions=str(tmp_path / "own.py"))
    held(open_exported(tmp_path / "out"), tmp_path / "own.py")


def test_functions_are_read_before_a_joint_is_fitted(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        export(tmp_path / "none.toml", tmp_path / "out", functions=tmp_path / "own.py")


def test_a_damaged_plan_is_refused(shoulder, tmp_path):
    folder = Path(shutil.copytree(shoulder.directory, tmp_path / "shoulder"))
    record = json.loads((folder / "model.json").read_text())
    del record["functions"]["compiled"][0]["steps"][-1]
    (folder / "model.json").write_text(json.dumps(record))
    done = command("verify", folder)
    assert done.exit_code == 2
    assert "model.json: damaged" in done.stderr
