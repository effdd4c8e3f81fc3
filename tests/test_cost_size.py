import subprocess
from pathlib import Path

import pytest
from elftools.elf.elffile import ELFFile

from ccgen.cost.program import compile_measured
from ccgen.cost.size import Size, read_map
from ccgen.errors import ToolError
from ccgen.export.package import export
from ccgen.targets.cores import COUNTED, core_named
from ccgen.targets.exported import open_exported

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def shoulder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("size") / "shoulder"
    export(ROOT / "examples" / "shoulder.toml", folder)
    return open_exported(folder)


def sections_and_symbols(program):
    """Bytes by name, as the ELF file itself has them."""
    with program.open("rb") as file:
        elf = ELFFile(file)
        sections = {section.name: section["sh_size"] for section in elf.iter_sections()}
        symbols = elf.get_section_by_name(".symtab").iter_symbols()
        return sections, {symbol.name: symbol["st_size"] for symbol in symbols}


def start_up_bytes(core, folder):
    """What the core's own start-up code takes: a program without any other code."""
    if core.name != "avr":
        return 0
    source, program = folder / "empty.c", folder / "empty.elf"
    source.write_text("volatile int data = 1, bss;\nint main(void) { return data + bss; }\n")
    subprocess.run([*core.compile, "-Os", str(source), "-o", str(program)], check=True)
    sections, symbols = sections_and_symbols(program)
    return sections[".text"] - symbols["main"]


@pytest.mark.parametrize("target", COUNTED)
def test_parts_are_what_the_linker_put_into_the_program(shoulder, target, tmp_path):
    core = core_named(target, COUNTED)
    compiled = compile_measured(shoulder, core, tmp_path)
    total = sum(read_map(compiled.map, shoulder.joint.name).values(), Size())
    sections, symbols = sections_and_symbols(compiled.program)
    code = sections[".text"] - symbols.get("main", 0) - start_up_bytes(core, tmp_path)
    # On AVR tables come first, and code begins on a word.
    assert 0 <= code - total.code <= (1 if target == "avr" else 0)
    inputs = symbols["cost_counts"] + symbols["cost_frames"]
    padding = sections[".data" if target == "avr" else ".rodata"] - inputs - total.constants
    # On the host the linker lays each object's tables on a boundary of up to 32 bytes.
    assert 0 <= padding <= (64 if target == "host" else 3), "before the harness's inputs"
    assert total.variables == 0
    linked = {f"shoulder_{name}" for name in ("capture_zero", "estimate", "integer_tip_pose")}
    assert linked <= set(symbols)
    assert not {"ccgen_slcan_feed", "shoulder_tip_pose"} & set(symbols)


@pytest.mark.parametrize("name", ["harness", "crt0"])
def test_a_joint_may_be_called_like_what_is_linked_beside_it(shoulder, name, tmp_path):
    joint = tmp_path / "joint.toml"
    joint.write_text((ROOT / "examples" / "shoulder.toml").read_text().replace("shoulder", name))
    export(joint, tmp_path / "out")
    sizes = []
    for folder in (shoulder, open_exported(tmp_path / "out")):
        objects = tmp_path / folder.joint.name
        objects.mkdir()
        compiled = compile_measured(folder, core_named("cortex-m4"), objects)
        sizes.append(read_map(compiled.map, folder.joint.name))
    assert sizes[0] == sizes[1]


MAP = """\
Discarded input sections

 .text.unused   0x00000000       0x40 a/arm.o

Memory Configuration

Linker script and memory map

.text           0x00010000       0x32
 .text.short    0x00010000       0x10 a/arm.o
 *fill*         0x00010010        0x2 00
 .text.of_a_longer_name
                0x00010012       0x20 a/arm_can.o

.bss            0x20000000        0x4
 COMMON         0x20000000        0x4 a/arm.o
"""


def test_padding_belongs_to_what_it_aligns_and_discarded_code_to_nothing(tmp_path):
    (tmp_path / "a.map").write_text(MAP)
    parts = read_map(tmp_path / "a.map", "arm")
    assert parts["estimator"] == Size(code=0x10, variables=4)
    assert parts["node"] == Size(code=0x22)


def test_a_map_of_another_form_is_an_error_and_not_nothing(tmp_path):
    (tmp_path / "a.map").write_text("# Path: a\n# Arch: arm64\n")
    with pytest.raises(ToolError, match=r"a\.map: no linker's map of GNU binutils"):
        read_map(tmp_path / "a.map", "arm")
