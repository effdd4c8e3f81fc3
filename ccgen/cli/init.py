"""`ccgen init`: a joint file to start from."""

from pathlib import Path
from typing import Annotated

import typer

from ccgen.cli.output import note
from ccgen.errors import InputError


def init(
    name: Annotated[str, typer.Argument(metavar="NAME", help="The joint's name, a C identifier.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="The file to write.  [default: NAME.toml]")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
) -> None:
    """Write a commented joint file that works as it is.

    \b
    Example:
      ccgen init shoulder -o shoulder.toml
    """
    from ccgen.joint.names import LONGEST_NAME, name_problem
    from ccgen.outputs import write_file

    problem = name_problem(name)
    if problem is not None:
        raise InputError(
            f"NAME: {name!r} {problem}; "
            f"give a C identifier of at most {LONGEST_NAME} characters, such as shoulder"
        )
    path = output or Path(f"{name}.toml")
    if path.exists() and not force:
        raise InputError(f"{path}: exists already; give another file with -o, or --force")
    write_file(path, joint_text(name).encode())
    note(f"wrote {path}; `ccgen fit {path}` tells how well its sensors do")


def joint_text(name: str) -> str:
    """Return the text of a commented joint file."""
    from ccgen.resources import template

    return template("joint.toml.j2").render(name=name)
