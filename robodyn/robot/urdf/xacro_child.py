"""What expands xacro files, in a process of its own: xacro, with expressions, files and variables that are bounded.

xacro keeps what it is at in variables of its modules, prints, and computes by Python's `eval`: so each file is expanded
by a process of its own, in which others stand for some of xacro's functions. It copies elements as it expands macros,
and forgets where they came from: so each gets an attribute when its file is parsed, which is taken away at the end.
"""

from __future__ import annotations

import errno
import glob
import json
import math
import os
import re
import stat
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout, suppress
from io import BytesIO, StringIO
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.dom.expatbuilder import ExpatBuilderNS
from xml.parsers import expat

from robodyn.robot.urdf.sources import VARIABLES, Search, home_of, package_name
from robodyn.robot.urdf.xacro_expressions import ADDRESS, MOST_ITEMS, Evaluator, RefusedError, checked
from robodyn.support.input_file import read_input
from robodyn.support.wording import shown, shown_path

MOST_FILES = 1_000
"""Files that an expansion reads, the same one as often as it is read."""
MOST_BYTES = 1 << 24
"""Of one of them."""
MOST_YAML = 1 << 20
"""Of a file of YAML, of which Python reads a megabyte in some seconds."""
_PACKAGE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]*")
_NAMED = "--package-path DIR names a folder to read from"
_NEVER = (
    *("os.", "subprocess.", "socket.", "ctypes.", "shutil.", "pty.", "mmap.", "fcntl."),
    *("winreg.", "_winapi.", "msvcrt."),
)


class Reach:
    """Reads for an expansion: what is trusted any regular file and any variable.

    Links followed, a file must lie in the package of the description (its folder, without a package.xml), a package
    path, a package found by its package.xml or another copy of one of these, or be named from the root on by an
    argument; not below names that begin with a dot. Arguments stand for variables of their names as well.
    """

    def __init__(
        self, file: str, package_paths: Sequence[str], arguments: Mapping[str, str], trusted: bool = False
    ) -> None:
        self._search = Search(file, tuple(package_paths))
        self._arguments, self._trusted = arguments, trusted
        whole = map(Path.absolute, self._search.folders)
        homes = [home_of(folder, *folder.parents) or folder for folder in whole]
        above = [str(home) for home in homes if os.path.realpath(home) != os.path.realpath(os.sep)]
        named = [value for value in arguments.values() if os.path.isabs(value) and os.path.isfile(value)]
        roots = [file, *above, *package_paths, *named]
        self._roots = set(map(os.path.realpath, roots))
        self._names = {name for name in map(package_name, homes) if name}
        self._read = 0

    def read(self, path: str, most: int = MOST_BYTES) -> bytes:
        """Return the bytes of a file; RefusedError where it is out of reach, or too much."""
        self._check(path)
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "this is no regular file", path)
        self._read += 1
        if self._read > MOST_FILES:
            raise RefusedError(f"reading more than {MOST_FILES} files")
        if status.st_size > most:
            raise RefusedError(f"reading {shown_path(path)}, of more than {most} bytes,")
        return read_input(path, most)

    def opened(self, path: str, *_: Any, **__: Any) -> BytesIO:
        """Return a file of YAML, open: what stands for `open` in xacro, which reads XML by `read`."""
        return BytesIO(self.read(path, MOST_YAML))

    def matching(self, pattern: str) -> list[str]:
        """Return the files that match the pattern of an include."""
        plain = re.split(r"[*?\[]", pattern, maxsplit=1)[0]
        self._check(os.path.dirname(plain))
        if os.pardir in pattern[len(plain) :].replace(os.sep, "/").split("/"):
            raise RefusedError(f"looking for {shown_path(pattern)}, which leads up again,")
        return glob.glob(pattern)

    def package(self, name: str) -> str:
        """Return the folder of a package, readable from then on; refused is one out of reach that has no
        package.xml."""
        found = self._search.share(name) if self._trusted or _PACKAGE.fullmatch(name) else None
        if found is None:
            raise LookupError(f"the package {shown(name)} is not found")
        folder = os.path.realpath(found)
        if not self._trusted and not self._within(folder):
            if package_name(found) is None:
                what = f"taking {shown_path(folder)}, without a package.xml, for the package {shown(name)}"
                raise RefusedError(what, _NAMED)
            self._roots.add(folder)
            self._names.add(name)
        return os.path.abspath(found)

    def variable(self, name: str) -> str | None:
        """Return an argument of that name, or a variable that says where packages are; another one is refused."""
        if name in self._arguments:
            return self._arguments[name]
        if not self._trusted and name not in VARIABLES:
            remedy = f"--xacro-arg {name if name.isidentifier() else 'NAME'}:=VALUE gives it one"
            raise RefusedError(f"asking for the variable {shown(name)} of the environment", remedy)
        return os.environ.get(name)

    def _check(self, path: str) -> None:
        real = os.path.realpath(path or os.curdir)
        if self._trusted or self._within(real):
            return
        home = home_of(*Path(real).parents)
        if home is not None and package_name(home) in self._names and _shows(str(home), real):
            return
        leads = "" if real == os.path.abspath(path) else f", which leads to {shown_path(real)}"
        within = any(Path(real).is_relative_to(root) for root in self._roots)
        where = "below a name that begins with a dot" if within else "outside of the packages that were found"
        raise RefusedError(f"reading {shown_path(path)}{leads}, {where},", "" if within else _NAMED)

    def _within(self, real: str) -> bool:
        return any(_shows(root, real) for root in self._roots)


def _shows(root: str, real: str) -> bool:
    """Return whether a file is a folder, or below it without a name that begins with a dot on the way."""
    inner = Path(real)
    return inner.is_relative_to(root) and not any(part.startswith(".") for part in inner.relative_to(root).parts)


MEMORY = 1 << 30
"""Bytes that an expansion may take, where the system can bound them."""
MOST_ELEMENTS = 50_000
"""Elements that are expanded, those of macros each time."""
MOST_OUTPUT = 1 << 26
"""Characters of the expansion."""
_LONGEST = 500
"""Characters of what is said of an error, which may quote the file."""
_DEEPEST = 3_000
"""Calls within each other, of which a macro within another takes about eight."""

_MARK = "robodyn-place"


def serve() -> None:
    """Answer the question on standard input, JSON on one line; end early where the one who asked has gone."""
    question = json.loads(sys.stdin.buffer.readline())
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)

    def end_with_the_parent() -> None:
        while os.read(0, 1):
            pass
        os._exit(1)

    threading.Thread(target=end_with_the_parent, daemon=True).start()
    with answers:
        answers.write(json.dumps(answer(**question)).encode())


def answer(
    path: str, package_paths: Sequence[str], args: Mapping[str, str], trusted: bool, seconds: float
) -> dict[str, Any]:
    """Expand a file in this process, which must have no other work. Return `text`, `files` and `places` (see
    `Expansion`) and the names of its `arguments`; or a `problem`, whether it is what was `refused`, and if so `file`,
    `line` and remedy."""
    given = _Arguments(args)
    sys.setrecursionlimit(_DEEPEST)
    bound(seconds, trusted)
    try:
        import xacro
        import yaml  # noqa: F401 - before imports are watched
        from xacro import substitution_args

        reach = Reach(path, package_paths, given, trusted)
        marks = Places(lambda name: reach.read(os.path.join(xacro.root_dir, name)), xacro.parse)
        expansion = _Bounded(xacro, marks)
        _replace(xacro, open=reach.opened, parse=marks.parse)
        _replace(substitution_args, _eval_find=reach.package)
        substitution_args._eval_dict["find"] = reach.package
    except Exception as error:
        return {"problem": f"xacro cannot be used: {_sentence(error)}", "refused": False}
    try:
        if not trusted:
            _restrict(xacro, substitution_args, reach, expansion)
            sys.addaudithook(_watch)
        with redirect_stdout(StringIO()):
            document = xacro.process_file(path, mappings=given)
            places = marks.taken(document.documentElement)
            text = document.toprettyxml(indent="  ")
        if not trusted and ADDRESS.search(text):
            raise RefusedError("the address of a function")
        if len(text) > MOST_OUTPUT:
            raise RefusedError(f"an expansion of more than {MOST_OUTPUT} characters")
    except (Exception, SystemExit) as error:
        refused = next((each for each in _causes(error) if isinstance(each, RefusedError)), None)
        what, remedy = (_sentence(error), "") if refused is None else (str(refused), refused.remedy)
        place = dict(zip(("file", "line"), expansion.place(), strict=True))
        return {"problem": what, "refused": refused is not None, "remedy": remedy, **place}
    return {"text": text, "files": marks.files, "places": places, "arguments": list(given.known)}


def bound(seconds: float, trusted: bool) -> None:
    """Let this process take so much processor time and memory, and unless it is trusted write no files."""
    for name in [name for name in os.environ if name not in (*VARIABLES, "PWD") and not trusted]:
        del os.environ[name]
    sys.dont_write_bytecode = True
    with suppress(ImportError):
        import resource

        limits = {"RLIMIT_AS": MEMORY, "RLIMIT_CPU": math.ceil(seconds), "RLIMIT_CORE": 0}
        for name, value in (limits if trusted else {**limits, "RLIMIT_FSIZE": 0, "RLIMIT_NPROC": 0}).items():
            with suppress(AttributeError, OSError, ValueError):
                kind = getattr(resource, name)
                _, most = resource.getrlimit(kind)
                least = value if most == resource.RLIM_INFINITY else min(value, most)
                resource.setrlimit(kind, (least, least + (name == "RLIMIT_CPU" and most != least)))


def _replace(module: Any, **others: Any) -> None:
    """Let others stand for functions of a module, which must have them; `open` is Python's own."""
    for name, other in others.items():
        if name != "open":
            getattr(module, name)
        setattr(module, name, other)


def _restrict(xacro: Any, substitution_args: Any, reach: Reach, expansion: _Bounded) -> None:
    """Let expressions be computed by our evaluator, variables be those within reach, and elements and texts be few."""
    symbols, eval_dict = xacro._global_symbols, substitution_args._eval_dict
    for space, names in (("python", ("sorted", "range")), ("xacro", ("load_yaml", "abs_filename", "dotify"))):
        symbols.update({name: symbols[space][name] for name in names})  # these only warn that they are old

    def variable(name: str) -> str:
        value = reach.variable(name)
        if value is None:
            raise substitution_args.SubstitutionException(f"environment variable {name} is not set")
        return value

    def optional(name: str, default: str = "") -> str:
        value = reach.variable(name)
        return default if value is None else value

    def argument(name: str) -> Any:
        value = substitution_args._eval_arg(name, args=xacro.substitution_args_context.get("arg", {}))
        return substitution_args.convert_value(value, "auto")

    def dirname() -> Any:
        return substitution_args._eval_dirname(None)

    own = [*symbols["xacro"].values(), variable, optional, reach.package, argument, dirname]
    evaluator = Evaluator([(function, function) for function in own], xacro.NameSpace)
    plain = {name: value for name, value in eval_dict.items() if not name.startswith("_")}
    plain |= {"list": list, "dict": dict, "map": map, "str": str, "float": float, "int": int}
    plain |= {"env": variable, "optenv": optional, "find": reach.package, "arg": argument, "dirname": dirname}

    def evaluated(source: str, context: Mapping[str, Any]) -> str:
        return str(evaluator.evaluate(source, substitution_args._DictWrapper(context.get("arg", {}), plain)))

    _replace(substitution_args, _eval=evaluated, _eval_env=variable, _eval_optenv=optional)
    _replace(
        xacro,
        safe_eval=lambda source, names, _=None: evaluator.evaluate(source, names),
        glob=SimpleNamespace(glob=reach.matching),
        eval_text=expansion.eval_text,
        handle_macro_call=expansion.handle_macro_call,
    )
    from yaml import SafeLoader

    flatten = SafeLoader.flatten_mapping

    def few_merged(loader: Any, node: Any) -> None:  # which puts the items of mappings that are merged in their places
        flatten(loader, node)
        if len(node.value) > MOST_ITEMS // 10:
            raise RefusedError(f"a mapping of more than {MOST_ITEMS // 10} items")

    SafeLoader.flatten_mapping = few_merged


class _Bounded:
    """xacro's ways to evaluate a text and to expand an element, with a count, and a note of where it is."""

    def __init__(self, xacro: Any, marks: Places) -> None:
        self._xacro, self._marks = xacro, marks
        self._eval_text, self._handle = xacro.eval_text, xacro.handle_macro_call
        self._elements = 0
        self._failed: str | None = None
        self._last = ""
        self._depth = 0

    def eval_text(self, text: str, symbols: Any) -> Any:
        """Return the value of a text; that of which it fails first is remembered, or the last one."""
        self._depth += 1
        try:
            value = self._eval_text(text, symbols)
            if isinstance(value, str):
                checked(value)
        except BaseException:
            self._failed = self._failed if self._failed is not None else text
            raise
        finally:
            self._depth -= 1
            self._last = text if self._depth == 0 else self._last
        return value

    def handle_macro_call(self, node: Any, macros: Any, symbols: Any) -> Any:
        """Expand an element that is no other of xacro's, whether it calls a macro or not."""
        self._elements += 1
        if self._elements > MOST_ELEMENTS:
            raise RefusedError(f"an expansion of more than {MOST_ELEMENTS} elements")
        return self._handle(node, macros, symbols)

    def place(self) -> tuple[str | None, int | None]:
        """Return the file and the line where the text that failed is written: of the macro, or the files around it."""
        text = self._failed if self._failed is not None else self._last
        around = [macro.history[-1][-1] for macro in self._xacro.macrostack[-1:]]
        around += reversed(self._xacro.filestack or [])
        for file in dict.fromkeys([*(os.path.abspath(each) for each in around if each), *self._marks.files]):
            line = _line_of(text, self._marks.sources.get(file, b""))
            if line is not None:
                return file, line
        return (os.path.abspath(around[-1]) if around and around[-1] else None), None


def _line_of(text: str, data: bytes) -> int | None:
    """Return the line of the first tag with an attribute, or of the first characters, that have a text in them."""
    parser, found = expat.ParserCreate(), list[int]()
    parser.buffer_text = True

    def start(_: str, attributes: dict[str, str]) -> None:
        if any(text in value for value in attributes.values()):
            found.append(parser.CurrentLineNumber)

    def characters(data: str) -> None:
        if text in data:
            found.append(parser.CurrentLineNumber)

    parser.StartElementHandler, parser.CharacterDataHandler = start, characters
    with suppress(expat.ExpatError, ValueError):
        parser.Parse(data, True)
    return found[0] if found and text.strip() else None


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = getattr(error, "exc", None) or error.__cause__ or error.__context__


def _sentence(error: BaseException) -> str:
    for cause in _causes(error):
        if isinstance(cause, MemoryError):
            return f"it needs more than {MEMORY >> 20} MB"
        if isinstance(cause, RecursionError):
            return "it is nested too deeply"
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _watch(event: str, arguments: tuple[Any, ...]) -> None:
    """Raise where Python is about to start a process, reach the network, write a file, or run code that is no
    module's."""
    wrong = event.startswith(_NEVER) and event not in ("os.listdir", "os.scandir")
    if event == "open":
        _, mode, flags = arguments
        wrong = bool(set(mode or "") & set("wax+")) or bool((flags or 0) & (os.O_WRONLY | os.O_RDWR))
    elif event == "exec":
        name = getattr(arguments[0], "co_filename", "<")
        wrong = name.startswith("<") and not name.startswith("<frozen ")
    if wrong:
        raise RefusedError(f"{event} in an expansion")


class _Arguments(dict[str, Any]):
    """Values of arguments that note which ones a file has: xacro asks whether one has a value, or for it."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.known: dict[str, None] = {}

    def __contains__(self, name: object) -> bool:
        self.known[str(name)] = None
        return super().__contains__(name)

    def __getitem__(self, name: str) -> Any:
        self.known[name] = None
        return super().__getitem__(name)


class Places:
    """What stands in for xacro's own parser, which it leaves what is no readable file: it notes files and their
    bytes."""

    def __init__(self, read: Callable[[str], bytes], parse: Callable[..., Any]) -> None:
        self._read, self._parse = read, parse
        self.files: list[str] = []
        self.sources: dict[str, bytes] = {}

    def parse(self, given: Any, filename: str | None = None) -> Any:
        """Return the document of a file, with marks."""
        if given is not None or filename is None:
            return self._parse(given, filename)
        try:
            data = self._read(filename)
        except OSError:
            return self._parse(None, filename)
        self.files.append(os.path.abspath(filename))
        self.sources[self.files[-1]] = data
        return _Marking(len(self.files) - 1).parseString(data)

    def taken(self, root: Any) -> list[tuple[int, int]]:
        """Return the file and the byte of each element in their order, and take the marks away."""
        places: list[tuple[int, int]] = []
        waiting = [(root, (0, 0))]
        while waiting:
            element, around = waiting.pop()
            mark = element.getAttribute(_MARK)
            if mark:
                element.removeAttribute(_MARK)
                number, _, start = mark.partition(" ")
                around = int(number), int(start)
            places.append(around)
            inner = [child for child in element.childNodes if child.nodeType == child.ELEMENT_NODE]
            waiting += [(child, around) for child in reversed(inner)]
        return places


class _Marking(ExpatBuilderNS):
    def __init__(self, number: int) -> None:
        super().__init__()
        self._number = number

    def start_element_handler(self, name: str, attributes: Any) -> None:
        super().start_element_handler(name, attributes)
        element: Any = self.curNode
        if not element.tagName.startswith("xacro:"):
            element.setAttribute(_MARK, f"{self._number} {self.getParser().CurrentByteIndex}")
