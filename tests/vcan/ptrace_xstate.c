/*
 * For linux.uml by LD_PRELOAD: lets it save and restore registers on processors whose extended
 * state is larger than its buffer, such as those with AMX.
 *
 * The kernel takes a whole state or none, so UML 6.1 panics there ("ptrace set fp regs failed").
 * Here the state is read whole and UML gets as much as it has room for; what it sets is laid over
 * the whole state. Buffers are static because UML's kernel stacks are small, and one thread traces.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

typedef long (*ptrace_t)(enum __ptrace_request request, pid_t pid, void *address, void *data);

static unsigned char bytes[65536];

long ptrace(enum __ptrace_request request, ...) {
    static ptrace_t real;
    va_list arguments;
    va_start(arguments, request);
    const pid_t pid = va_arg(arguments, pid_t);
    void *const address = va_arg(arguments, void *);
    void *const data = va_arg(arguments, void *);
    va_end(arguments);
    if (real == NULL) {
        real = (ptrace_t)dlsym(RTLD_NEXT, "ptrace");
    }
    const int sets = request == PTRACE_SETREGSET;
    if ((!sets && request != PTRACE_GETREGSET) || address != (void *)NT_X86_XSTATE) {
        return real(request, pid, address, data);
    }
    struct iovec whole = {bytes, sizeof bytes};
    struct iovec *const part = data;
    const long result = real(PTRACE_GETREGSET, pid, address, &whole);
    if (result < 0) {
        return result;
    }
    if (part->iov_len > whole.iov_len) {
        part->iov_len = whole.iov_len;
    }
    if (sets) {
        memcpy(bytes, part->iov_base, part->iov_len);
        return real(PTRACE_SETREGSET, pid, address, &whole);
    }
    memcpy(part->iov_base, bytes, part->iov_len);
    return result;
}
