"""The folder that an export writes."""

from __future__ import annotations

from pathlib import Path

from orchestrator.errors import InputError


def make_folder(folder: Path) -> None:
    """Make a new folder.

    Raises:
        InputError: if it exists or cannot be made.
    """
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        raise InputError(f"{folder} already exists; choose another --out, or remove it first") from None
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror}") from None
