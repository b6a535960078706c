"""The command line of dxc, for the library alone.

    python3 dxc.py libdxcompiler.so -T ps_6_0 -E main [-spirv] [-Fo OUT] FILE.hlsl [, -T vs_6_0 …]
    python3 dxc.py libdxcompiler.so --version

Commas separate runs, since loading the library takes longer than one. Errors of the compiler go to stderr, and the exit code is 1. The library's interface is COM without Windows: objects that
begin with a table of methods. In its versions up to 1.7 `IUnknown` has a virtual destructor there, which takes two places
in each table.
"""

import ctypes
import sys
import uuid

CLSID_LIBRARY = "6245d6af-66e0-48fd-80b4-4d271796748c"
IID_LIBRARY = "e5204dc7-d18c-4c3c-bdfb-851673980fe7"
CLSID_COMPILER = "73e22d93-e6ce-47f3-b5bf-f0664f39c1b0"
IID_COMPILER = "8c210bf3-011f-4422-8d70-6f9acb8db617"
IID_VERSION = "b04f5b50-2059-4f12-a8ff-a1e0cde1cc7e"
# places of methods: QueryInterface, AddRef, Release and two destructors come first
QUERY_INTERFACE = 0
FIRST = 5
CREATE_BLOB_ON_HEAP = FIRST + 4
COMPILE, GET_VERSION = FIRST, FIRST
GET_STATUS, GET_RESULT, GET_ERRORS = FIRST, FIRST + 1, FIRST + 2
BUFFER_POINTER, BUFFER_SIZE = FIRST, FIRST + 1
UTF_8 = 65001
Pointer, Number, Word = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_wchar_p


def identifier(text):
    return uuid.UUID(text).bytes_le


def method(thing, place, *types, result=ctypes.c_int32):
    table = ctypes.cast(thing, ctypes.POINTER(ctypes.POINTER(Pointer))).contents
    function = ctypes.CFUNCTYPE(result, Pointer, *types)(table[place])
    return lambda *arguments: function(thing, *arguments)


def made(what, call, *arguments):
    """The object that a call writes to its last argument."""
    thing = Pointer()
    code = call(*arguments, ctypes.byref(thing))
    if code != 0 or not thing:
        sys.exit(f"{what}: error code {code & 0xFFFFFFFF:#010x}")
    return thing


def content(blob):
    pointer = method(blob, BUFFER_POINTER, result=Pointer)()
    size = method(blob, BUFFER_SIZE, result=ctypes.c_size_t)()
    return ctypes.string_at(pointer, size) if size else b""


def compile_file(compiler, library, options, path):
    with open(path, "rb") as file:
        text = file.read()
    create = method(library, CREATE_BLOB_ON_HEAP, ctypes.c_char_p, Number, Number, Pointer)
    source = made("the source", create, text, len(text), UTF_8)
    words = ["-spirv"] if "-spirv" in options else []
    result = made(
        "the compiler",
        method(compiler, COMPILE, Pointer, Word, Word, Word, Pointer, Number, Pointer, Number, Pointer, Pointer),
        source, path, options["-E"], options["-T"], (Word * len(words))(*words), len(words), None, 0, None,
    )
    status = ctypes.c_int32()
    method(result, GET_STATUS, Pointer)(ctypes.byref(status))
    if status.value != 0:
        said = content(made("the messages", method(result, GET_ERRORS, Pointer)))
        said = said.decode(errors="replace").strip("\0\n") or "the compiler failed without a message"
        sys.exit(f"-T {options['-T']} -E {options['-E']}:\n{said}")
    code = content(made("the code", method(result, GET_RESULT, Pointer)))
    if not code:
        sys.exit("the compiler wrote nothing")
    if "-Fo" in options:
        with open(options["-Fo"], "wb") as file:
            file.write(code)


def version(compiler):
    interface = made("IDxcVersionInfo", method(compiler, QUERY_INTERFACE, Pointer, Pointer), identifier(IID_VERSION))
    major, minor = Number(), Number()
    method(interface, GET_VERSION, Pointer, Pointer)(ctypes.byref(major), ctypes.byref(minor))
    return f"libdxcompiler {major.value}.{minor.value}"


def main(library_path, *words):
    create = ctypes.CDLL(library_path).DxcCreateInstance
    create.argtypes, create.restype = [Pointer, Pointer, Pointer], ctypes.c_int32
    compiler = made("IDxcCompiler", create, identifier(CLSID_COMPILER), identifier(IID_COMPILER))
    if words == ("--version",):
        print(version(compiler))
        return
    library = made("IDxcLibrary", create, identifier(CLSID_LIBRARY), identifier(IID_LIBRARY))
    rest = [*words, ","]
    while rest:
        end = rest.index(",")
        run, rest = rest[:end], rest[end + 1:]
        compile_file(compiler, library, *parsed(run))


def parsed(words):
    """Options and their values, and the file."""
    options, rest = {}, list(words[:-1])
    while rest:
        word = rest.pop(0)
        options[word] = rest.pop(0) if word in ("-T", "-E", "-Fo") else ""
    return options, words[-1]


if __name__ == "__main__":
    main(*sys.argv[1:])
