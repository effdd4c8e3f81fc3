import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_joint_checks import loaded
from typer.testing import CliRunner

import ccgen
from ccgen.cli.main import app
from ccgen.cost import costs as measuring
from ccgen.cost.budget import Budget, excesses
from ccgen.cost.harness import REPEATS
from ccgen.cost.measure import measure
from ccgen.cost.program import compile_measured
from ccgen.cost.snapshots import snapshots
from ccgen.cost.stack import read_disassembly, read_frames, worst_case
from ccgen.errors import CheckError
from ccgen.export.package import export
from ccgen.targets.cores import COUNTED, core_named
from ccgen.targets.exported import open_exported

ROOT = Path(__file__).resolve().parent.parent
TARGETS = ("host", "cortex-m0", "cortex-m4", "riscv32", "avr")


@pytest.fixture(scope="module")
def shoulder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cost") / "shoulder"
    export(ROOT / "examples" / "shoulder.toml", folder)
    return folder


@pytest.fixture(scope="module")
def costs(shoulder):
    exported = open_exported(shoulder)
    return {target: measure(exported, target) for target in TARGETS}


def run(*arguments):
    result = CliRunner().invoke(app, ["cost", *map(str, arguments)])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


@pytest.mark.parametrize("target", TARGETS)
def test_every_core_is_measured_whole(costs, target):
    cost = costs[target]
    record = cost.record()
    assert record["flash_bytes"] == record["code_bytes"] + record["constant_bytes"]
    assert all(cost.parts[part].code > 0 for part in ("estimator", "kinematics", "node"))
    assert all(part.variables == 0 for part in cost.parts.values()), "no globals"
    assert 0 < cost.times.frame < cost.times.snapshot
    parts = (cost.times.receive, cost.times.estimate, cost.times.tip_pose, cost.times.transmit)
    assert max(parts) < cost.times.snapshot <= sum(parts)
    assert 0 < cost.times.health < cost.times.transmit
    assert record["instructions_per_estimate"] == cost.times.estimate
    assert record["instructions_per_jacobian"] > cost.times.tip_pose
    assert "integer_tip_jacobian" not in cost.stacks, "no node calls it"
    assert record["unit"] == ("cycles" if target == "avr" else "instructions")
    assert not {"instructions_per_check", "instructions_per_examination"} & set(record)


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("checked") / "joint"
    export(ccgen.fit(ccgen.parse(loaded())), folder)
    return folder


def test_checks_are_measured_on_snapshots_that_are_quiet_and_on_such_as_all_groups_contradict(
    checked,
):
    exported = open_exported(checked)
    groups = exported.guarded.groups
    assert len(groups) == 2
    taken = snapshots(exported)
    differences = (rows - exported.model.readings.zero for rows in (taken.whole, taken.examined))
    quiet, examined = differences
    for group in groups:
        assert group.quiet(quiet[:, group.own]).all()
        assert not group.verdicts(quiet[:, group.own])[0].any()
        assert group.verdicts(examined[:, group.own])[0].all()
    assert np.abs(quiet).max() > 500, "bent, not just the straight joint"


def test_checks_are_told_beside_the_estimate(checked, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    result = run(checked, "--target", "cortex-m4", "--target", "avr", "--json")
    arm, avr = json.loads(result.stdout)["targets"]
    parts = ("receive", "estimate", "check", "tip_pose", "transmit")
    for told in (arm, avr):
        spent = [told[f"instructions_per_{part}"] for part in parts]
        assert 0 < told["instructions_per_check"] <= 0.6 * told["instructions_per_estimate"]
        assert told["instructions_per_examination"] > 3 * told["instructions_per_check"]
        assert 0.99 * sum(spent) < told["instructions_per_snapshot"] <= sum(spent)
    assert "follow" in arm["stacks"]
    table = run(checked, "--target", "cortex-m4").stdout
    titles, row = (
        line.split() for line in table.splitlines() if line.startswith(("target", "cor"))
    )
    assert row[titles.index("check")] == f"{arm['instructions_per_check']:,}"
    examined = f"{arm['instructions_per_examination']:,} (cortex-m4) instead."
    assert examined in " ".join(table.split())


def test_what_examines_sensors_stays_in_program_memory_on_avr(checked):
    avr = measure(open_exported(checked), "avr")
    assert avr.parts["estimator"].constants < 768, "no more than what is read at every snapshot"


def test_examined_snapshots_are_followed_until_a_sensor_is_left_out(checked):
    exported = open_exported(checked)
    rows = np.repeat(snapshots(exported).examined[-1:], REPEATS, axis=0)
    followed = exported.guarded.follow(rows)
    assert (followed.values[-1] != followed.values[0]).any(), "a fallback serves at the last"


def test_another_level_of_optimisation_is_measured_and_named(shoulder, costs):
    result = run(shoulder, "--target", "cortex-m4", "--optimise", "s", "--json")
    (smaller,) = json.loads(result.stdout)["targets"]
    usual = costs["cortex-m4"].record()
    assert (smaller["optimisation"], usual["optimisation"]) == ("-Os", "-O2")
    assert smaller["code_bytes"] < usual["code_bytes"]


def test_a_core_that_reads_tables_from_ram_needs_ram_for_them(costs):
    avr, arm = costs["avr"], costs["cortex-m0"]
    assert avr.ram_bytes == avr.state_bytes + avr.constant_bytes
    assert avr.parts["node"].constants < 256, "tables of CRCs stay in program memory"
    assert avr.parts["estimator"].constants < 128, "so does all but the weights of all sensors"
    assert arm.ram_bytes == arm.state_bytes


def test_the_same_folder_costs_the_same_again(shoulder, costs):
    assert measure(open_exported(shoulder), "cortex-m4") == costs["cortex-m4"]


@pytest.mark.parametrize(
    ("target", "most"),
    [("cortex-m0", 10_500), ("cortex-m4", 5_000), ("riscv32", 7_500), ("avr", 60_000)],
)
def test_a_snapshot_keeps_within_its_instructions(costs, target, most):
    assert costs[target].times.snapshot <= most


@pytest.mark.parametrize("name", ["shoulder", "spine"])
def test_a_node_has_no_float_where_the_core_has_none(name, tmp_path):
    exported = open_exported(export(ROOT / "examples" / f"{name}.toml", tmp_path / name).directory)
    core = core_named("cortex-m0", COUNTED)
    folder = tmp_path / "objects"
    folder.mkdir()
    program = compile_measured(exported, core, folder).program
    listing = [core.binutils("nm"), str(program)]
    symbols = subprocess.run(listing, capture_output=True, text=True, check=True).stdout
    assert f" {name}_node_receive" in symbols
    assert re.findall(r"__aeabi_(?:[df]|c[df]|\w+2[df])\w*|__\w+[sd]f[123]", symbols) == []


def test_the_estimator_on_cortex_m0_fits_a_kilobyte(costs):
    assert costs["cortex-m0"].parts["estimator"].code <= 1024


def test_budgets_name_target_what_and_by_how_much(costs):
    cost = costs["cortex-m0"]
    held = Budget(cost.flash_bytes, cost.ram_bytes, cost.stack_bytes, cost.times.estimate)
    assert list(excesses([cost], held, named=True)) == []
    flash, stack, estimate = cost.flash_bytes - 7, cost.stack_bytes - 1, cost.times.estimate - 2
    assert list(excesses([cost], Budget(flash, None, stack, estimate), named=True)) == [
        f"cortex-m0: flash: {flash + 7} bytes, 7 over the budget of {flash}",
        f"cortex-m0: stack: {stack + 1} bytes, 1 over the budget of {stack}",
        f"cortex-m0: one estimate: {estimate + 2} instructions, 2 over the budget of {estimate}",
    ]


@pytest.mark.parametrize(
    ("named", "budget", "held"),
    [
        (True, Budget(flash=0), TARGETS),
        (True, Budget(instructions=0), TARGETS),
        (False, Budget(flash=0), ("cortex-m0", "cortex-m4", "riscv32", "avr")),
        (False, Budget(instructions=0), ("cortex-m0", "cortex-m4", "riscv32")),
        (False, Budget(), ()),
    ],
)
def test_budgets_hold_for_named_targets_or_for_all_microcontrollers(costs, named, budget, held):
    over = excesses(list(costs.values()), budget, named)
    assert [line.partition(":")[0] for line in over] == list(held)


def test_over_budget_ends_with_status_1(shoulder):
    result = run(shoulder, "--target", "cortex-m3", "--max-flash", "100", "--json")
    assert result.exit_code == 1
    assert "over budget: cortex-m3: flash: " in result.stderr
    (target,) = json.loads(result.stdout)["targets"]
    assert {"flash_bytes", "ram_bytes", "stack_bytes", "instructions_per_estimate"} <= set(target)


@pytest.fixture
def only_cortex_m4(monkeypatch):
    present = measuring.missing_tools

    def missing(core, to_run=True):
        return present(core, to_run) if core.name == "cortex-m4" else [f"gcc-no-{core.name}"]

    monkeypatch.setattr(measuring, "missing_tools", missing)


@pytest.mark.usefixtures("only_cortex_m4")
def test_targets_without_their_tools_are_left_out_by_name(shoulder):
    result = run(shoulder)
    assert result.exit_code == 0
    assert "left out: avr: needs gcc-no-avr; install with `apt-get" in result.stderr
    assert "\ncortex-m4 " in result.stdout
    chosen = run(shoulder, "--target", "avr")
    assert chosen.exit_code == 2
    assert "avr: needs gcc-no-avr" in chosen.stderr


@pytest.mark.usefixtures("only_cortex_m4")
def test_a_budget_does_not_pass_on_targets_that_were_left_out(shoulder):
    unchecked = run(shoulder, "--max-flash", 10**6)
    assert unchecked.exit_code == 2
    assert (
        "error: the budget is not checked on cortex-m0: needs gcc-no-cortex-m0; install with "
        "`apt-get install gcc-no-cortex-m0`, or name the targets with --target" in unchecked.stderr
    )
    assert "\ncortex-m4 " in unchecked.stdout
    assert run(shoulder, "--max-flash", 10**6, "--target", "cortex-m4").exit_code == 0
    over = run(shoulder, "--max-flash", 1)
    assert over.exit_code == 1
    assert "over budget: cortex-m4: flash: " in over.stderr


@pytest.mark.parametrize(
    ("absent", "option"), [("host", "--max-flash"), ("avr", "--max-instructions")]
)
def test_a_budget_does_not_miss_what_it_does_not_hold_for(shoulder, monkeypatch, absent, option):
    monkeypatch.setattr(measuring, "COUNTED", (absent, "cortex-m4"))
    missing = {absent: ["gcc"], "cortex-m4": []}
    monkeypatch.setattr(measuring, "missing_tools", lambda core, to_run: missing[core.name])
    result = run(shoulder, option, 10**6)
    assert result.exit_code == 0, result.stderr
    assert f"left out: {absent}: " in result.stderr


def test_without_the_extra_the_message_says_how_to_install_it(shoulder):
    program = (
        "import sys; sys.modules['unicorn'] = None\n"
        f"from ccgen.cli.main import main; main(['cost', {str(shoulder)!r}])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "counting needs unicorn; install it with `pip install 'ccgen[cost]'`" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_unknown_target_is_refused(shoulder):
    result = run(shoulder, "--target", "z80")
    assert result.exit_code == 2
    assert "--target: z80 is unknown; known: host, cortex-m0" in result.stderr


DISASSEMBLY = """
00010000 <outer>:
   10000:\tb510      \tpush\t{r4, lr}
   10002:\tf7ff fffe \tbl\t10010 <inner>
   10006:\tbd10      \tpop\t{r4, pc}

00010010 <inner>:
   10010:\tb5f0      \tpush\t{r4, r5, r6, r7, lr}
   10012:\tb083      \tsub\tsp, #12
"""


def test_frames_of_the_library_come_from_its_instructions():
    functions = read_disassembly(DISASSEMBLY)
    assert worst_case("outer", functions, {"outer": 24}) == (24 + 32, ("outer", "inner"))
    assert worst_case("outer", functions, {}) == (8 + 32, ("outer", "inner"))


def test_recursion_and_calls_through_pointers_have_no_bound():
    looped = DISASSEMBLY + "   10014:\tf7ff fffe \tbl\t10000 <outer>\n"
    frames = {"outer": 8, "inner": 32}
    with pytest.raises(CheckError, match="recursion"):
        worst_case("outer", read_disassembly(looped), frames)
    pointed = DISASSEMBLY + "   10014:\t4798      \tblx\tr3\n"
    with pytest.raises(CheckError, match="through a pointer"):
        worst_case("outer", read_disassembly(pointed), frames)


def test_frames_known_at_run_time_only_are_refused(tmp_path):
    (tmp_path / "a.su").write_text("a.c:3:5:fixed\t24\tstatic\n")
    assert read_frames(tmp_path) == {"fixed": 24}
    (tmp_path / "b.su").write_text("b.c:9:5:varying\t24\tdynamic\n")
    with pytest.raises(CheckError, match="varying: its frame is dynamic"):
        read_frames(tmp_path)
