"""Which names a joint may have: they become C identifiers, file names and a CMake target."""

import re

LONGEST_NAME = 20
"""Longest name: the DBC allows 32 characters, and `_LENGTHS_15` and the like must follow."""


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_KEYWORDS_C = _words(
    """
    auto break case char const continue default do double else enum extern float for goto if
    inline int long register restrict return short signed sizeof static struct switch typedef
    union unsigned void volatile while alignas alignof bool constexpr false nullptr static_assert
    thread_local true typeof typeof_unqual asm fortran
    """
)
"""Keywords of C99, C11 and C23."""

_KEYWORDS_CPP = _words(
    """
    and and_eq bitand bitor catch char16_t char32_t char8_t class co_await co_return co_yield
    compl concept consteval constinit const_cast decltype delete dynamic_cast explicit export
    friend import module mutable namespace new noexcept not not_eq operator or or_eq override
    final private protected public reinterpret_cast requires static_cast template this throw try
    typeid typename using virtual wchar_t xor xor_eq
    """
)
"""What C++14, C++17 and C++20 add, the alternative tokens included."""

_STANDARD_TYPES = _words(
    """
    blkcnt blkcnt64 blksize caddr can_err_mask canid cc char8 char16 char32 clock clockid
    comparison_fn
    cookie_io_functions cookie_read_function cookie_seek_function daddr dev div error fenv fexcept
    fpos fpos64 fpregset fsblkcnt fsblkcnt64 fsfilcnt fsfilcnt64 fsid gid greg gregset id imaxdiv
    ino ino64 int8 int16 int32 int64 int_fast8 int_fast16 int_fast32 int_fast64 int_least8
    int_least16 int_least32 int_least64 intmax intptr key ldiv lldiv loff max_align mbstate
    mcontext mode nfds nlink off off64 pid ptrdiff quad rsize sa_family sig sig_atomic sigevent
    sighandler siginfo sigset sigval size sockaddr socklen speed ssize stack suseconds tcflag time
    timer u_int8 u_int16 u_int32 u_int64 u_quad ucontext uid uint8 uint16 uint32 uint64 uint_fast8
    uint_fast16 uint_fast32 uint_fast64 uint_least8 uint_least16 uint_least32 uint_least64 uintmax
    uintptr useconds wchar wctrans wctype wint
    """
)
"""Names whose `NAME_t` is a type of the C library, of POSIX or of Linux."""

_RESERVED_PREFIXES = ("ccgen", "port_", "pthread_")
"""Beginnings of names of the runtime, of the ports, and of POSIX threads."""

_STANDARD_HEADERS = _words(
    """
    alloca assert complex ctype endian errno fcntl features fenv float ieeefp inttypes iso646
    limits locale math newlib picolibc poll pthread sched select semaphore setjmp signal stdalign
    stdarg stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string strings
    syslimits termios tgmath threads time uchar unistd wchar wctype
    """
)
"""Names whose `NAME.h`, on the include path, would hide a header of the C library."""

_TAKEN = _words(
    "all clean help install main package port ports posix selftest shared socketcan test"
)
"""Names of files, functions and build targets that the exported folder needs itself."""


def name_problem(name: str) -> str | None:
    """Return why `name` cannot be a joint's name, or None where it can."""
    if not name:
        return "is empty"
    if len(name) > LONGEST_NAME:
        return f"has {len(name)} characters, {LONGEST_NAME} at most fit the DBC"
    if re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) is None:
        return "is not a C identifier"
    if name.startswith("_") or "__" in name:
        return "is reserved in C and C++ (leading or double underscore)"
    if name in _KEYWORDS_C | _KEYWORDS_CPP:
        return "is a keyword of C or C++"
    if name in _STANDARD_TYPES:
        return f"collides with the type {name}_t of the C library"
    lowered = name.lower()  # files meet on file systems that ignore case
    if lowered.startswith(_RESERVED_PREFIXES):
        return "collides with the names of the runtime, its ports or POSIX threads"
    if lowered in _STANDARD_HEADERS:
        return f"collides with the header {lowered}.h of the C library"
    if lowered in _TAKEN:
        return "collides with a file or target of the exported folder"
    return None
