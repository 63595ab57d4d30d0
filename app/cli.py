"""The command `nonius`.

    nonius [gui [NETWORK]]   open the window
    nonius run NETWORK       run a network, write its pictures with their certificates
    nonius verify NETWORK    whether what a network states of its errors is so, on data of known truth
    nonius check FILE        what a picture claims, checked; or whether a network could run
    nonius modules           the modules there are
    nonius describe MODULE   ports, parameters, accuracy and source of a module
    nonius gallery           run the packaged networks, write their pictures and a page
    nonius doctor            whether this machine can draw, and what to install
    nonius warm              compile the kernels now
    nonius bench [NAME]      the benchmarks of a checkout

Exit codes: 0 ok; 1 a module failed; 2 a wrong network or wrong words; 3 a demand not met, or a claim that does not
hold; 130 cancelled.
"""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Sequence
from importlib import import_module
from typing import NoReturn

from app import __version__
from app.commands.console import Console, Usage
from app.engine.errors import ModuleFailed, NoniusError, hint

CANCELLED = 130
COMMANDS = ("gui", "run", "verify", "check", "modules", "describe", "gallery", "doctor", "warm", "bench")
EPILOG = """exit codes: 0 ok; 1 a module failed; 2 a wrong network or wrong words;
3 a demand not met, or a claim of a picture that does not hold; 130 cancelled"""


class Parser(argparse.ArgumentParser):
    """Raises a sentence where argparse would print its usage and exit."""

    def __init__(self, *words: object, **options: object) -> None:
        super().__init__(*words, **{"allow_abbrev": False, **options})  # type: ignore[arg-type]  # handed on as they are

    def error(self, message: str) -> NoReturn:
        """One sentence; `main` makes it exit code 2."""
        if message.startswith("unrecognized arguments: "):
            word = message.split(": ", 1)[1].split()[0]
            if word.startswith("-"):
                close = hint(word, _options(self))
                raise Usage(f"there is no option {word!r}{close} (`{self.prog} COMMAND --help` lists them)")
            raise Usage(f"{word!r} is one word too many (`{self.prog} --help` says more)")
        raise Usage(f"{message} (`{self.prog} --help` says more)")


def _options(of: argparse.ArgumentParser) -> set[str]:
    """All long options of a parser and its commands."""
    found: set[str] = set()
    for action in of._actions:
        found |= {name for name in action.option_strings if name.startswith("--")}
        for inner in action.choices.values() if isinstance(action.choices, dict) else ():
            found |= _options(inner)
    return found


def parser() -> Parser:
    """All commands and their options."""
    top = Parser(
        prog="nonius",
        description="Networks of modules in which every wire carries the data and what is known about its accuracy.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"nonius {__version__}")
    shared = Parser(add_help=False)
    shared.add_argument("--quiet", action="store_true", help="say nothing but what went wrong")
    shared.add_argument("--verbose", action="store_true", help="say everything, with tracebacks")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", parser_class=Parser)

    def command(name: str, words: str) -> argparse.ArgumentParser:
        return commands.add_parser(
            name, help=words, description=words[0].upper() + words[1:] + ".", parents=[shared], epilog=EPILOG,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )  # fmt: skip

    gui = command("gui", "open the window, with a network if one is named")
    gui.add_argument("network", metavar="NETWORK", nargs="?", help="a file, the name of a packaged network, or a picture")
    gui.add_argument("--theme", choices=("light", "dark", "system"), help="of this start; else as it was chosen")
    _run(command("run", "run a network and write its pictures with their certificates"))
    _verify(command("verify", "run a network on data of known truth and judge what it states of its errors"))
    check = command("check", "check what a picture claims, or whether a network could run")
    check.add_argument("file", metavar="FILE", help="picture.accuracy.json, its picture, or a network")
    check.add_argument("--no-run", action="store_true", help="compare digests only; do not run the network again")
    check.add_argument("--threads", type=_count, metavar="N", help="threads that work at once")
    modules = command("modules", "list the modules there are")
    modules.add_argument("--json", action="store_true", help="as JSON")
    describe = command("describe", "ports, parameters, accuracy and source of a module")
    describe.add_argument("module", metavar="MODULE", help="its id, or the part of it that only one has: contour")
    gallery = command("gallery", "run the packaged networks and write their pictures and a page")
    gallery.add_argument("--to", metavar="FOLDER", help="where; resources/gallery of a checkout, else ./gallery")
    gallery.add_argument("--threads", type=_count, metavar="N", help="threads that work at once")
    command("doctor", "whether this machine can draw, and what to install")
    command("warm", "compile the kernels now, so that no picture waits for it")
    bench = command("bench", "run the benchmarks of a checkout")
    bench.add_argument("name", metavar="NAME", nargs="?", help="one of them; all by default")
    return top


def _verify(verify: argparse.ArgumentParser) -> None:
    verify.add_argument("network", metavar="NETWORK", help="a file, a packaged network, or a picture made by nonius")
    verify.add_argument(
        "--set", metavar="NODE.PARAM=VALUE", action="append", default=[], dest="edits", help="another value of a parameter"
    )
    verify.add_argument("--runs", type=_count, metavar="N", default=20, help="realisations of each error; 20 by default")
    verify.add_argument("--seed", type=_count, metavar="N", default=1, help="of the fields and the errors")
    verify.add_argument("--report", metavar="FILE", help="all findings as JSON")


def _run(run: argparse.ArgumentParser) -> None:
    run.add_argument("network", metavar="NETWORK", help="a file, the name of a packaged network, or a picture made by nonius")
    run.add_argument(
        "--set", metavar="NODE.PARAM=VALUE", action="append", default=[], dest="edits", help="another value of a parameter"
    )
    run.add_argument(
        "--out", metavar="NODE[.OUTPUT]=FILE", action="append", default=[], dest="outs",
        help="write an output: a view as .png, shapes as .vtp, samples as .vti, tables as .csv; "
        "without it each view goes to the current folder",
    )  # fmt: skip
    run.add_argument("--report", metavar="FILE", help="what ran, how long, with which budget, as JSON")
    run.add_argument(
        "--require", metavar="DEMAND", action="append", default=[], dest="demands",
        help="'contour-1.lines.position.max < 0.01 cell'; exit code 3 if it is not met",
    )  # fmt: skip
    run.add_argument(
        "--for", metavar="NODE.PARAM=VALUES", action="append", default=[], dest="sequences",
        help="once for each value: 0..1/11 (eleven even ones), 1e-2..1e-8/7 log, or a, b, c; files are numbered; "
        "given twice, for each combination; '--for saved' takes the sequence of the network",
    )  # fmt: skip
    run.add_argument("--film", metavar="FPS", type=_count, help="with --for: each view as a film too, an animated PNG")
    run.add_argument("--threads", type=_count, metavar="N", help="threads that work at once")


def _count(text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"takes a whole number from 1, not {text!r}")
    return number


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code; what goes wrong is one sentence on stderr."""
    words = list(sys.argv[1:] if argv is None else argv)
    console = Console(quiet="--quiet" in words, verbose="--verbose" in words)
    try:
        return _dispatch(words, console)
    except KeyboardInterrupt as stop:
        console.complain(f"nonius: {stop or 'cancelled'}")
        return CANCELLED
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # the reader has gone; nothing is left to say
        return 0
    except NoniusError as error:
        console.complain(f"nonius: {error}")
        console.detail(error.traceback if isinstance(error, ModuleFailed) else "")
        return error.exit_code
    except OSError as error:
        console.complain(f"nonius: {error.filename or ''}: {error.strerror or error}".replace(" : ", " "))
        console.detail(traceback.format_exc())
        return 2
    except SystemExit as leaving:  # --help and --version
        return leaving.code if isinstance(leaving.code, int) else 0
    except Exception as error:
        console.complain(f"nonius: the program itself is at fault ({type(error).__name__}: {error}); --verbose says where")
        console.detail(traceback.format_exc())
        return 1


def _dispatch(words: list[str], console: Console) -> int:
    first = next((w for w in words if not w.startswith("-")), "")
    if first and first not in COMMANDS:
        raise Usage(f"there is no command {first!r}{hint(first, COMMANDS)}")
    top = parser()
    if not words:
        words = ["gui"]
    elif not first and not any(w in ("-h", "--help", "--version") for w in words):
        top.print_help()
        return 2
    options = top.parse_args(words)
    _check_place()
    return int(import_module(f"app.commands.{options.command}").run(options, console))


def _check_place() -> None:
    from app.paths import intruder

    if folder := intruder():
        raise Usage(f"another package called 'modules' is in the way: {folder}; give nonius-explorer an environment of its own")


def script() -> NoReturn:
    """What the console script calls: threads that still work when the answer is out do not hold it up."""
    code = main()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            pass
    if code == CANCELLED:
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    script()
