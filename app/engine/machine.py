"""What the process may use of the machine: cores and memory, as its container allows."""

from __future__ import annotations

import ctypes
import math
import os
import sys
from pathlib import Path

CGROUPS = Path("/sys/fs/cgroup")


def cores() -> int:
    """Cores that this process may run on, at least 1."""
    mine = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)
    for folder in _groups():
        quota, _, period = _text(folder / "cpu.max").partition(" ")
        if quota.isdigit() and period.strip().isdigit():
            mine = min(mine, math.ceil(int(quota) / int(period)))
    return max(1, mine)


def memory() -> int:
    """Bytes of RAM that this process may use."""
    limits = [_physical()]
    for folder in _groups():
        for name in ("memory.max", "memory.limit_in_bytes"):
            text = _text(folder / name).strip()
            if text.isdigit():
                limits.append(int(text))
    return min(limits)


def _groups() -> list[Path]:
    """The cgroup folders of this process, from its own up to the root."""
    folders = [CGROUPS, CGROUPS / "memory"]
    for line in _text(Path("/proc/self/cgroup")).splitlines():
        _, controllers, inside = line.split(":", 2)
        top = CGROUPS / "memory" if "memory" in controllers else CGROUPS
        place = top / inside.lstrip("/")
        folders += [p for p in (place, *place.parents) if p.is_relative_to(top)]
    return folders


def _physical() -> int:
    if sys.platform == "win32":
        kilobytes = ctypes.c_ulonglong(0)
        if ctypes.windll.kernel32.GetPhysicallyInstalledSystemMemory(ctypes.byref(kilobytes)):
            return kilobytes.value * 1024
        return 8 << 30
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (ValueError, OSError):
        return 8 << 30


def _text(path: Path) -> str:
    try:
        return path.read_text()
    except OSError:
        return ""
