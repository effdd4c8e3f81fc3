import filecmp
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from pathlib import Path

import pytest
from processes import runs
from typer.testing import CliRunner
from waiting import PATIENCE, becomes

from ccgen.cli.main import app
from ccgen.errors import InputError, ToolError
from ccgen.placement import Evolution, Search
from ccgen.study import sources, spread
from ccgen.study.joints import Settings, StudyJoint, all_joints, chosen_joints, study_joint
from ccgen.study.run import Store, run_study
from ccgen.study.tables import table2, table2_json

QUICK = Settings(Evolution(individuals=30, generations=2), Search(enumerated=500, starts=1))
JOINTS = (StudyJoint(12, 3), StudyJoint(12, 8), StudyJoint(16, 1))
KILLED_AFTER_ONE_JOINT = """
import os, signal
from ccgen.study.run import Store
save = Store.save
def save_one(self, joint, results):
    save(self, joint, results)
    os.kill(os.getpid(), signal.SIGKILL)
Store.save = save_one
"""


def run(folder, executor, joints=JOINTS, settings=QUICK, finished=None):
    store = Store(folder / "joints", settings)
    records = run_study(joints, settings, store, executor, finished or (lambda joint, before: None))
    (folder / "table2.json").write_bytes(table2_json(table2(records)))
    return folder


def reproduce(folder, *more, before=""):
    """Start the command on three joints, in a program that may do something before."""
    program = f"{before}\nfrom ccgen.cli.main import main\nmain()\n"
    command = [sys.executable, "-c", program, "reproduce", "-o", str(folder)]
    options = ["--joints", "12:1,12:2,12:3", "--individuals", "20", "--generations", "1"]
    return subprocess.Popen(
        [*command, *options, *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def ended(study):
    """Wait for the command's end; gives its status and what it printed on stdout and stderr."""
    printed, said = study.communicate(timeout=10 * PATIENCE)
    return study.returncode, printed.decode(), said.decode()


def first_joint(folder):
    """Wait for the first file of a finished joint."""
    assert becomes(lambda: any(folder.glob("joints/m*.json"))), "no joint was finished"
    return next(folder.glob("joints/m*.json"))


def same_files(one, other):
    names = sorted(str(path.relative_to(one)) for path in one.rglob("*") if path.is_file())
    assert names == sorted(
        str(path.relative_to(other)) for path in other.rglob("*") if path.is_file()
    )
    _, different, errors = filecmp.cmpfiles(one, other, names, shallow=False)
    return not different and not errors


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    with spread.on_processes(2) as executor:
        return run(tmp_path_factory.mktemp("undisturbed"), executor)


def test_order_and_number_of_processes_leave_every_byte_alone(undisturbed, tmp_path):
    with spread.on_processes(1) as executor:
        again = run(tmp_path, executor, joints=JOINTS)
    assert same_files(undisturbed, again)


def test_a_dask_cluster_of_two_workers_gives_the_same_bytes(undisturbed, tmp_path):
    from distributed import LocalCluster

    # Two threads each: joints that share a worker must not share random numbers either.
    with (
        LocalCluster(n_workers=2, threads_per_worker=2, dashboard_address=":0") as workers,
        spread.on_cluster(workers.scheduler_address, PATIENCE) as executor,
    ):
        on_cluster = run(tmp_path, executor)
    assert same_files(undisturbed, on_cluster)


def test_no_scheduler_is_one_line():
    with (
        pytest.raises(InputError, match="no Dask scheduler answers at tcp://127"),
        spread.on_cluster("tcp://127.0.0.1:1", timeout=0.3),
    ):
        raise AssertionError("connected")


def test_an_address_that_is_none_is_one_line(tmp_path):
    status, _, said = ended(reproduce(tmp_path / "out", "--scheduler", "nowhere"))
    assert status == 2
    assert said.splitlines() == [
        "ccgen: error: --scheduler: no Dask scheduler answers at nowhere;"
        " give the address that it prints, such as tcp://192.0.2.1:8786"
    ]


@pytest.fixture
def scheduler():
    """A Dask scheduler without workers: what is submitted waits."""
    with dask("scheduler", "--no-dashboard", "--host", "127.0.0.1", "--port", "0") as process:
        yield process
        process.kill()


def dask(what, *options):
    """Start a part of a Dask cluster."""
    command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *options]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


def address_of(scheduler):
    for line in scheduler.stderr:
        if match := re.search(r"Scheduler at: *(tcp://\S+)", line):
            return match[1]
    raise AssertionError("the scheduler ended")


@pytest.mark.parametrize(
    ("victim", "by", "status", "message"),
    [
        ("study", signal.SIGINT, 130, "ccgen: interrupted"),
        ("scheduler", signal.SIGKILL, 2, "ccgen: error: the Dask cluster at ADDRESS was lost;"),
    ],
)
def test_a_study_on_a_cluster_ends_in_one_line(tmp_path, scheduler, victim, by, status, message):
    address = address_of(scheduler)
    with dask("worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard") as worker:
        # So many joints that they are not finished before the first one is noticed.
        study = reproduce(tmp_path / "out", "--scheduler", address, "--joints", "12,16,20,24")
        finished = first_joint(tmp_path / "out")
        os.kill({"study": study, "scheduler": scheduler}[victim].pid, by)
        end = ended(study)
        worker.kill()
    *progress, line = end[2].splitlines()
    assert all(" joints/s, " in told for told in progress)  # of a busy machine
    assert end[0] == status
    assert line.startswith(message.replace("ADDRESS", address))
    assert ("finished joints are kept" in line) == (victim == "scheduler")
    assert finished.exists()


def test_an_error_cancels_what_waits_on_a_cluster(scheduler):
    waiting = []

    def interrupted():
        with spread.on_cluster(address_of(scheduler), PATIENCE) as executor:
            waiting.append(executor.submit(os.getpid))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    with pytest.raises(CancelledError):
        waiting[0].result(PATIENCE)


def test_a_process_that_is_killed_is_one_line():
    with (
        pytest.raises(ToolError, match="finished joints are kept"),
        spread.on_processes(1) as executor,
    ):
        executor.submit(os.abort).result()


def test_finished_joints_are_not_studied_again(undisturbed):
    class Refusing:
        def submit(self, *work):
            raise AssertionError("studied again")

    seen = []
    store = Store(undisturbed / "joints", QUICK)
    records = run_study(JOINTS, QUICK, store, Refusing(), lambda *what: seen.append(what))
    assert seen == [(joint, True) for joint in JOINTS]
    assert table2_json(table2(records)) == (undisturbed / "table2.json").read_bytes()


@pytest.mark.parametrize("spoilt", [b"", b"{", b"[]", b'{"made_with": null}'])
def test_a_spoilt_joint_file_counts_as_unfinished(tmp_path, spoilt):
    store = Store(tmp_path, QUICK)
    (tmp_path / "m12-rom3.json").write_bytes(spoilt)
    assert store.load(StudyJoint(12, 3)) is None


def cut_short(stored):
    del stored["scores"][-1]


def twice(stored):
    stored["scores"].append(stored["scores"][0])


def another_cell(stored):
    stored["scores"][3]["sensors"] = 7


def without_score(stored):
    del stored["scores"][3]["percent_rom"]


def nan(stored):
    stored["scores"][3]["percent_rom"] = math.nan


def infinite(stored):
    stored["scores"][3]["percent_rom"] = math.inf


def text(stored):
    stored["scores"][3]["percent_rom"] = "1.0"


def without_fold(stored):
    del stored["beyond_fold"]


def without_scores(stored):
    stored["scores"] = None


@pytest.mark.parametrize(
    "spoil",
    [
        *(cut_short, twice, another_cell, without_score, nan, infinite, text),
        *(without_fold, without_scores),
    ],
)
def test_a_joint_file_that_is_not_whole_is_studied_again(undisturbed, tmp_path, spoil):
    folder = tmp_path / "out"
    shutil.copytree(undisturbed, folder)
    path = folder / "joints" / "m12-rom3.json"
    stored = json.loads(path.read_bytes())
    spoil(stored)
    path.write_text(json.dumps(stored))
    store = Store(folder / "joints", QUICK)
    assert store.load(JOINTS[0]) is None
    assert store.load(JOINTS[1]) is not None


def test_a_file_of_another_joint_is_not_taken_for_this_one(undisturbed, tmp_path):
    shutil.copytree(undisturbed, tmp_path / "out")
    joints = tmp_path / "out" / "joints"
    shutil.copy(joints / "m12-rom8.json", joints / "m12-rom3.json")
    shutil.copy(joints / "m12-rom3.json", joints / "m16-rom1.json")
    seen = []
    with spread.on_processes(1) as executor:
        again = run(tmp_path / "out", executor, finished=lambda *what: seen.append(what))
    assert sorted(seen) == [(joint, joint == StudyJoint(12, 8)) for joint in JOINTS]
    assert same_files(undisturbed, again)


def test_results_of_other_sources_count_as_unfinished(undisturbed, tmp_path, monkeypatch):
    package = tmp_path / "ccgen"
    shutil.copytree(sources.PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(sources, "PACKAGE", package)
    assert Store(undisturbed / "joints", QUICK).load(JOINTS[0]) is not None
    with (package / "placement" / "objective.py").open("a") as file:
        file.write("# changed\n")
    assert Store(undisturbed / "joints", QUICK).load(JOINTS[0]) is None


def test_every_module_that_a_joint_needs_is_in_the_fingerprint():
    code = (
        "import sys, ccgen.study.joints\n"
        "for name, module in sys.modules.items():\n"
        "    if name.startswith('ccgen.'): print(module.__file__)\n"
    )
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    needed = {Path(line) for line in printed.stdout.decode().splitlines()}
    without_numbers = {sources.PACKAGE / "errors.py", sources.PACKAGE / "study" / "__init__.py"}
    assert needed - without_numbers <= set(sources.sources())


def test_joints_of_other_settings_count_as_unfinished(undisturbed):
    other = Settings(Evolution(individuals=30, generations=2, seed=1), QUICK.search)
    assert Store(undisturbed / "joints", QUICK).load(JOINTS[0]) is not None
    assert Store(undisturbed / "joints", other).load(JOINTS[0]) is None


def test_a_killed_run_resumes_to_the_same_bytes(tmp_path):
    def study(folder, *more, before=""):
        return ended(reproduce(folder, "--processes", "1", *more, before=before))

    killed, whole = tmp_path / "killed", tmp_path / "whole"
    assert study(killed, before=KILLED_AFTER_ONE_JOINT)[0] == -signal.SIGKILL
    assert len(list(killed.glob("joints/m*.json"))) == 1
    assert not (killed / "table2.json").exists()
    status, shown, said = study(killed)
    assert status == 0, said
    assert "1 of 3 joints were finished before" in said
    status, printed, said = study(whole, "--json")
    assert status == 0, said
    answer = json.loads(printed)
    assert answer.pop("seconds") > 0
    assert answer == json.loads((whole / "table2.json").read_bytes())
    assert "only 3 of the paper's 80 joints, so no difference" in " ".join(shown.split())
    for name in ("joints/.", "."):
        leftovers = [path.name for path in (killed / name).iterdir() if path.name[0] == "."]
        assert not leftovers
    assert same_files(killed, whole)


def test_cluster_and_processes_exclude_each_other(tmp_path):
    options = [
        "reproduce",
        "-o",
        str(tmp_path / "out"),
        "--processes",
        "2",
        "--scheduler",
        "tcp://x",
    ]
    result = CliRunner().invoke(app, options)
    assert result.exit_code == 2
    assert "--processes" in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_seed_below_zero_is_refused(tmp_path):
    result = CliRunner().invoke(app, ["reproduce", "-o", str(tmp_path / "out"), "--seed", "-1"])
    assert result.exit_code == 2
    assert "'--seed'" in result.stderr
    assert not (tmp_path / "out").exists()


def test_workers_end_when_their_parent_is_killed(tmp_path):
    code = (
        "import time\n"
        "from ccgen.study import spread\n"
        "if __name__ == '__main__':\n"
        "    with spread.on_processes(1) as executor:\n"
        "        print(executor.submit(__import__('os').getpid).result(), flush=True)\n"
        "        time.sleep(60)\n"
    )
    script = tmp_path / "parent.py"
    script.write_text(code)
    process = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE)
    worker = int(process.stdout.readline())
    process.kill()
    process.wait()
    process.stdout.close()
    assert becomes(lambda: not runs(worker))


def test_an_error_ends_joints_in_work_at_once():
    workers = []

    def interrupted():
        with spread.on_processes(1) as executor:
            workers.append(executor.submit(os.getpid).result())
            executor.submit(time.sleep, 2 * PATIENCE)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert becomes(lambda: not runs(workers[0]))


def test_processes_work_with_one_thread_each():
    with spread.on_processes(1) as executor:
        assert executor.submit(os.getenv, "OPENBLAS_NUM_THREADS").result() == "1"


def test_no_process_is_refused():
    with pytest.raises(InputError, match="processes: 0"), spread.on_processes(0):
        raise AssertionError("started")


def test_all_joints_are_those_of_table_1():
    joints = all_joints()
    assert len(joints) == len(set(joints)) == 80
    assert {joint.segments for joint in joints} == {12, 16, 20, 24, 28, 32, 36, 40, 44, 48}
    assert {joint.range_of_motion_deg for joint in joints} == {1, 2, 3, 4, 5, 6, 7, 8}


def test_joints_are_chosen_by_segments_and_range():
    assert chosen_joints("48:8, 12:3,12:3") == (StudyJoint(12, 3), StudyJoint(48, 8))
    assert chosen_joints("16") == tuple(StudyJoint(16, degrees) for degrees in range(1, 9))


@pytest.mark.parametrize("text", ["", "13", "12:9", "12:3;16:3", "12:3:1", "x"])
def test_joints_that_table_1_does_not_have_are_refused(text):
    with pytest.raises(InputError, match="no joint of Table 1"):
        chosen_joints(text)


def test_a_joint_has_every_cell_once():
    record = study_joint(StudyJoint(12, 3), QUICK)
    cells = [(s["placement"], s["method"], s["sensors"]) for s in record["scores"]]
    assert len(cells) == len(set(cells)) == 1 + 8 * 5
    assert json.loads(json.dumps(record)) == record
    assert not record["beyond_fold"]
