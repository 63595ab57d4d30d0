"""What can go wrong with a network, in sentences for people.

    NoniusError
    ├── NetworkError             the network or the words given are wrong           exit code 2
    │   ├── UnknownName          no such node, module, port, output, parameter; names the nearest
    │   ├── WireError            a wire that may not be
    │   │   ├── TypeMismatch     the output does not fit the port
    │   │   ├── PortTaken        the port has a wire already
    │   │   └── CycleError       the wire would close a circle
    │   ├── ValueRefused         a value that the parameter does not take
    │   ├── NameTaken            a second node of one id
    │   ├── DocumentError        a file that cannot be read as a network
    │   │   └── NewerSchema      it was written by a later version of the program
    │   └── CatalogueError       modules that contradict each other
    ├── ModuleFailed             a node gave no result                              exit code 1
    │   ├── Unwired              a required port has no wire
    │   ├── FileMissing          a data file is not there
    │   ├── FileChanged          a data file changed while it was read
    │   ├── Unaccounted          it broke the law of the budget
    │   └── ProcessDied          the process that ran it ended
    └── DemandError              a demand (`--require`) is not met                   exit code 3

Each sentence says what is wrong, where, and what to do.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any, ClassVar, Self


class NoniusError(Exception):
    """Base of all; `node` and `port` say where, as far as known."""

    exit_code: ClassVar[int] = 1

    def __init__(self, sentence: str, *, node: str = "", port: str = "") -> None:
        super().__init__(sentence)
        self.node = node
        self.port = port

    @property
    def sentence(self) -> str:
        """What is wrong and what to do."""
        return str(self.args[0])

    def record(self) -> dict[str, Any]:
        """As plain values, for a report."""
        return {"error": type(self).__name__, "node": self.node, "port": self.port, "sentence": str(self)}


class NetworkError(NoniusError):
    """The network, or what was asked of it, is wrong."""

    exit_code: ClassVar[int] = 2


class UnknownName(NetworkError):
    """No node, module, port, output or parameter of that name."""


class WireError(NetworkError):
    """A wire that may not be."""


class TypeMismatch(WireError):
    """The output does not fit the port."""


class PortTaken(WireError):
    """The port has a wire already."""


class CycleError(WireError):
    """The wire would close a circle."""


class ValueRefused(NetworkError):
    """A value that the parameter does not take."""


class NameTaken(NetworkError):
    """A second node of one id, or an id that cannot be written in a file."""


class DocumentError(NetworkError):
    """A file that cannot be read as a network."""


class NewerSchema(DocumentError):
    """A file of a later version of the program."""


class CatalogueError(NetworkError):
    """Modules that contradict each other."""


class ModuleFailed(NoniusError):
    """A node gave no result.

    Parameters
    ----------
    sentence : what went wrong, without the node's name
    node, title : the node and its module's title
    traceback : text, "" if the sentence says all
    """

    exit_code: ClassVar[int] = 1
    keep: ClassVar[bool] = True
    """Whether the same firing fails again, so that it is not tried until someone asks."""

    def __init__(
        self, sentence: str, *, node: str = "", port: str = "", title: str = "", traceback: str = ""
    ) -> None:
        super().__init__(sentence, node=node, port=port)
        self.title = title
        self.traceback = traceback

    def __str__(self) -> str:
        place = self.node + (f".{self.port}" if self.port else "")
        who = f"{place} ({self.title})" if place and self.title else place or self.title
        return f"{who}: {self.sentence}" if who else self.sentence

    def forget(self) -> None:
        """Let go of the frames it was raised in, and of the data in them; the text of the traceback stays."""
        self.__traceback__ = self.__cause__ = self.__context__ = None

    def at(self, node: str) -> Self:
        """The same failure, of another node with the same key."""
        if node == self.node:
            return self
        return type(self)(self.sentence, node=node, port=self.port, title=self.title, traceback=self.traceback)


class Unwired(ModuleFailed):
    """A required port has no wire."""


class FileMissing(ModuleFailed):
    """A data file is not there."""

    keep: ClassVar[bool] = False


class FileChanged(ModuleFailed):
    """A data file changed while it was read."""

    keep: ClassVar[bool] = False


class Unaccounted(ModuleFailed):
    """A term of an input neither goes on nor is ended in an output: the law of the budget."""


class ProcessDied(ModuleFailed):
    """The process that ran the node ended."""

    keep: ClassVar[bool] = False


class DemandError(NoniusError):
    """A demand is not met, or is about nothing."""

    exit_code: ClassVar[int] = 3


def nearest(name: str, names: Iterable[str]) -> str:
    """The most similar name, or ""."""
    known = sorted({str(n) for n in names})
    folded = {n.casefold(): n for n in reversed(known)}
    close = difflib.get_close_matches(str(name).casefold(), folded, n=1, cutoff=0.55)
    return folded[close[0]] if close else ""


def hint(name: str, names: Iterable[str], *, show: int = 8) -> str:
    """"; did you mean 'x'?", or the list of what there is, or "; there is none"."""
    known = sorted({str(n) for n in names})
    if close := nearest(name, known):
        return f"; did you mean {close!r}?"
    if not known:
        return "; there is none"
    if len(known) > show:
        return f"; there are {len(known)}, from {known[0]!r} to {known[-1]!r}"
    return f"; there {'is' if len(known) == 1 else 'are'} {', '.join(map(repr, known))}"
