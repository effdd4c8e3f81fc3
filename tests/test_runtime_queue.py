"""The queue of frames between an interrupt and the main loop."""

import subprocess

import pytest
from runtime_c import COMPILERS, HERE, compile_c
from waiting import PATIENCE


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("level", ["-O0", "-O3"])
@pytest.mark.parametrize("places", [1, 16, 128])
def test_frames_come_out_whole_and_in_order_whenever_the_interrupt_strikes(compiler, level, places):
    flags = (level, f"-DCCGEN_QUEUE_PLACES={places}", "-fsanitize=undefined")
    program = compile_c([HERE / "queue_driver.c"], flags, compiler)
    done = subprocess.run(
        [program, "3000"], capture_output=True, text=True, timeout=PATIENCE, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("places", [0, 3, 256])
def test_a_number_of_places_that_does_not_wrap_with_a_byte_does_not_compile(places):
    with pytest.raises(AssertionError, match="queue_places_are_a_power_of_two"):
        compile_c([HERE / "queue_driver.c"], [f"-DCCGEN_QUEUE_PLACES={places}"])
