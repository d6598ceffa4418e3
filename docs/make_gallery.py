"""Make the pictures of the gallery by running the commands the gallery shows.

The commands are read from the page itself, so what is printed there is what was run:
every line of a ``console`` block that starts with ``$ atlas``, continued over lines that
end with a backslash. A picture is made again only when the page, or the package, is newer.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

_ROOT = Path(__file__).parent.parent
_BLOCK = re.compile(r"^```console\n(.*?)^```", re.MULTILINE | re.DOTALL)
_ATLAS = [sys.executable, "-c", "from fivebar_atlas.cli import main; main()"]


def commands(text: str) -> list[list[str]]:
    """Return the arguments of every ``atlas`` command in a page, in their order."""
    lines = "".join(_BLOCK.findall(text)).replace("\\\n", " ").splitlines()
    prompt = "$ atlas "
    return [shlex.split(line.removeprefix(prompt)) for line in lines if line.startswith(prompt)]


def make(page: Path, folder: Path) -> None:
    """Run the commands of a page in a folder; fail on the first that fails.

    Parameters
    ----------
    page
        The Markdown page with the commands.
    folder
        Where they run, and so where their outputs are; made if it is missing.

    Raises
    ------
    RuntimeError
        If a command fails; the message carries what it printed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    # The commands name configurations as one does in the root of the repository.
    shutil.copytree(_ROOT / "configs", folder / "configs", dirs_exist_ok=True)
    sources = [page, *_ROOT.glob("configs/*.toml"), *_ROOT.glob("fivebar_atlas/**/*.py")]
    newest = max(file.stat().st_mtime for file in sources)
    for arguments in commands(page.read_text(encoding="utf-8")):
        output = _output(arguments)
        if output is not None:
            target = folder / output
            if target.exists() and target.stat().st_mtime > newest:
                continue
            arguments = [*arguments, "--overwrite"]
        done = subprocess.run(
            [*_ATLAS, *arguments], cwd=folder, capture_output=True, text=True, check=False
        )
        if done.returncode:
            raise RuntimeError(f"atlas {shlex.join(arguments)} failed:\n{done.stderr}")


def _output(arguments: list[str]) -> str | None:
    return arguments[arguments.index("-o") + 1] if "-o" in arguments else None


if __name__ == "__main__":
    here = Path(__file__).parent
    make(here / "gallery.md", here / "_generated" / "gallery")
