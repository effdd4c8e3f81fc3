"""What can go wrong, as a small tree; the command line prints each as one line."""


class CcgenError(Exception):
    """Base of every error that a user can cause or mend; `exit_status` is the program's."""

    exit_status = 2


class InputError(CcgenError):
    """Bad input: the message names the file, the key and what would be right."""


class ArgumentError(InputError):
    """A value that a function cannot take; the command line says its options instead.

    Attributes:
        problem: what is wrong, and what would be right.
        arguments: names of the arguments that it concerns.
    """

    def __init__(self, problem: str, *arguments: str) -> None:
        super().__init__(problem, *arguments)
        self.problem, self.arguments = problem, arguments

    def __str__(self) -> str:
        return f"{', '.join(self.arguments)}: {self.problem}"


def require_least(least: int, argument: str, value: int) -> None:
    """Refuse a value of an argument that is too small.

    Raises:
        ArgumentError: naming the argument.
    """
    if value < least:
        raise ArgumentError(f"{value} is too small; give at least {least}", argument)


class ReachError(InputError):
    """A bending angle that no point of a load case reaches; names the reachable one."""


class FormatError(InputError):
    """No fixed-point format fits; names the sensor and the remedy."""


class ToolError(CcgenError):
    """A program that is needed is missing; names it and how to install it."""


class BusError(CcgenError):
    """A bus that went away; names it and why."""


class CheckError(CcgenError):
    """A check failed: a mismatch, a lost frame, a budget."""

    exit_status = 1
