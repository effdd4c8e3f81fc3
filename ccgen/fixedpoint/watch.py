"""What verdicts of the check do to a group of sensors over time.

A group's state is three small integers: a sensor, a run of snapshots, and whether the sensor is
left out. After each snapshot:

    not every sensor of the group has a reading:
        run = 0; where no sensor is left out, sensor = nobody
    no sensor is left out:
        the verdict names nobody:    sensor = nobody, run = 0
        it names the sensor:         run = run + 1
        it names another:            sensor = that one, run = 1
        run = OUT_AFTER:             the sensor is left out, run = 0
    the sensor is left out:
        no alarm, or one that names another:   run = run + 1
        an alarm that names it, or nobody:     run = 0
        run = BACK_AFTER:                      nobody is left out, sensor = nobody, run = 0

What is left out counts as without a reading from that very snapshot on, and as with one from the
snapshot on that brings it back. While a sensor is left out the check goes on with all readings, its
own among them: a sensor that agrees again comes back; one that is sound, but was left out by
mistake, comes back although another is named.
"""

from dataclasses import dataclass

from ccgen.fixedpoint.consistency import NOBODY

OUT_AFTER = 3
"""Snapshots in a row that name a sensor until it is left out."""

BACK_AFTER = 20
"""Snapshots in a row that do not speak against a sensor until it comes back."""


@dataclass(frozen=True)
class Watch:
    """State of one group."""

    sensor: int = NOBODY
    """In the group: the one that the last snapshot named, or that is left out."""
    run: int = 0
    """Snapshots in a row that speak for a change."""
    out: bool = False
    """Whether the sensor is left out."""

    def after(self, complete: bool, alarm: bool, named: int) -> "Watch":
        """The state that a snapshot leaves.

        Args:
            complete: whether every sensor of the group has a reading.
            alarm: of the check; False where it is not complete.
            named: a sensor of the group or `NOBODY`.
        """
        if not complete:
            return Watch(self.sensor if self.out else NOBODY, 0, self.out)
        if self.out:
            return self._leaving(alarm, named)
        if named == NOBODY:
            return Watch()
        run = self.run + 1 if named == self.sensor else 1
        return Watch(named, 0, True) if run == OUT_AFTER else Watch(named, run)

    def _leaving(self, alarm: bool, named: int) -> "Watch":
        if alarm and named in (self.sensor, NOBODY):
            return Watch(self.sensor, 0, True)
        run = self.run + 1
        return Watch() if run == BACK_AFTER else Watch(self.sensor, run, True)
