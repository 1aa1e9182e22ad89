/* Faults at the calls by which a process changes the files below a folder; loaded with LD_PRELOAD.
 *
 * FAULTS_FOLDER is the folder, FAULTS_CONTROL a file that holds a struct control and is shared with the test. Every call
 * that changes something is counted; what happens at the call of number `at` (and, if `lasting`, at those after it)
 * is `how`: an errno to fail with, or one of the deaths below. With `at` 0 nothing happens.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#define DIE 1000  /* before the call */
#define TEAR 1001 /* after half of what should be written */
#define LOSE 1002 /* before the call, and what was appended to files and not synced is gone */

struct control { volatile uint64_t calls, at, lasting, how, faults; };

static struct control *control;
static char folder[PATH_MAX];

static int is_below(const char *path) {
    size_t length = strlen(folder);
    return control && path && !strncmp(path, folder, length) && (path[length] == '/' || !path[length]);
}

static int path_of(int fd, char *path) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, PATH_MAX - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return 1;
}

/* How much of each file is known to be on the disk. */
#define FILES 4096
static struct { char *path; off_t synced; } files[FILES];
static int known;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static int find(const char *path) {
    for (int i = 0; i < known; i++)
        if (files[i].path && !strcmp(files[i].path, path)) return i;
    return -1;
}

static void note(const char *path, int is_sync) {
    struct stat stat_of;
    /* Shared memory is made anew after a crash. */
    size_t length = strlen(path);
    if (length > 4 && !strcmp(path + length - 4, "-shm")) return;
    if (stat(path, &stat_of) || !S_ISREG(stat_of.st_mode)) return;
    pthread_mutex_lock(&lock);
    int i = find(path);
    if (i < 0 && known < FILES) {
        files[i = known++].path = strdup(path);
        files[i].synced = stat_of.st_size;
    }
    if (i >= 0 && (is_sync || files[i].synced > stat_of.st_size)) files[i].synced = stat_of.st_size;
    pthread_mutex_unlock(&lock);
}

static void renamed(const char *from, const char *to) {
    pthread_mutex_lock(&lock);
    int old = find(to), i = find(from);
    if (old >= 0) { free(files[old].path); files[old].path = NULL; }
    if (i >= 0) { free(files[i].path); files[i].path = strdup(to); }
    pthread_mutex_unlock(&lock);
}

static void die(void) {
    for (;;) kill(getpid(), SIGKILL);
}

/* 0: go on; TEAR; or the errno to fail with. */
static int fault(void) {
    uint64_t number = __atomic_add_fetch(&control->calls, 1, __ATOMIC_SEQ_CST);
    uint64_t at = control->at, how = control->how;
    if (!at || number < at || (number > at && !control->lasting)) return 0;
    __atomic_add_fetch(&control->faults, 1, __ATOMIC_SEQ_CST);
    if (how == DIE) die();
    if (how == LOSE) {
        pthread_mutex_lock(&lock);
        for (int i = 0; i < known; i++) {
            struct stat stat_of;
            if (files[i].path && !stat(files[i].path, &stat_of) && stat_of.st_size > files[i].synced)
                if (truncate(files[i].path, files[i].synced)) {}
        }
        die();
    }
    return (int)how;
}

__attribute__((constructor)) static void begin(void) {
    const char *path = getenv("FAULTS_CONTROL"), *below = getenv("FAULTS_FOLDER");
    if (!path || !below || !realpath(below, folder)) return;
    int fd = open(path, O_RDWR);
    if (fd < 0) return;
    void *shared = mmap(NULL, sizeof *control, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    if (shared != MAP_FAILED) control = shared;
}

#define REAL(name) static __typeof__(&name) real; if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)
#define FAIL(how) do { errno = (how) >= DIE ? EIO : (how); return -1; } while (0)
#define OPEN_FD(fd) char path[PATH_MAX]; int ours = control && path_of(fd, path) && is_below(path)

#define WRITES(name, parameters, arguments, half) \
    ssize_t name parameters { \
        REAL(name); OPEN_FD(fd); \
        if (ours) { \
            note(path, 0); \
            int how = fault(); \
            if (how == TEAR) { if (half) {} die(); } \
            if (how) FAIL(how); \
        } \
        return real arguments; \
    }

WRITES(write, (int fd, const void *bytes, size_t size), (fd, bytes, size), real(fd, bytes, size / 2))
WRITES(pwrite, (int fd, const void *bytes, size_t size, off_t at), (fd, bytes, size, at), real(fd, bytes, size / 2, at))
WRITES(pwrite64, (int fd, const void *bytes, size_t size, off64_t at), (fd, bytes, size, at), real(fd, bytes, size / 2, at))
WRITES(writev, (int fd, const struct iovec *parts, int count), (fd, parts, count), real(fd, parts, count / 2))
WRITES(pwritev, (int fd, const struct iovec *parts, int count, off_t at), (fd, parts, count, at), real(fd, parts, count / 2, at))

#define SYNCS(name) \
    int name(int fd) { \
        REAL(name); OPEN_FD(fd); \
        if (ours) { int how = fault(); if (how == TEAR) die(); if (how) FAIL(how); } \
        int done = real(fd); \
        if (ours && !done) note(path, 1); \
        return done; \
    }
SYNCS(fsync)
SYNCS(fdatasync)

#define CHANGES(name, parameters, arguments, ours) \
    int name parameters { \
        REAL(name); \
        if (ours) { int how = fault(); if (how == TEAR) die(); if (how) FAIL(how); } \
        return real arguments; \
    }
CHANGES(link, (const char *from, const char *to), (from, to), is_below(to))
CHANGES(linkat, (int a, const char *from, int b, const char *to, int flags), (a, from, b, to, flags), is_below(to))
CHANGES(unlink, (const char *path), (path), is_below(path))
CHANGES(unlinkat, (int at, const char *path, int flags), (at, path, flags), is_below(path))
CHANGES(mkdir, (const char *path, mode_t mode), (path, mode), is_below(path))
CHANGES(mkdirat, (int at, const char *path, mode_t mode), (at, path, mode), is_below(path))

int rename(const char *from, const char *to) {
    REAL(rename);
    int ours = is_below(to);
    if (ours) { int how = fault(); if (how == TEAR) die(); if (how) FAIL(how); }
    int done = real(from, to);
    if (ours && !done) renamed(from, to);
    return done;
}

#define CUTS(name, type) \
    int name(int fd, type size) { \
        REAL(name); OPEN_FD(fd); \
        if (ours) { int how = fault(); if (how == TEAR) die(); if (how) FAIL(how); } \
        int done = real(fd, size); \
        if (ours && !done) note(path, 0); \
        return done; \
    }
CUTS(ftruncate, off_t)
CUTS(ftruncate64, off64_t)

/* Opening counts where it may create. */
#define OPENS(name) \
    int name(const char *path, int flags, ...) { \
        REAL(name); \
        mode_t mode = 0; \
        if (flags & (O_CREAT | O_TMPFILE)) { va_list rest; va_start(rest, flags); mode = va_arg(rest, mode_t); va_end(rest); } \
        if ((flags & O_CREAT) && is_below(path)) { int how = fault(); if (how == TEAR) die(); if (how) FAIL(how); } \
        return real(path, flags, mode); \
    }
OPENS(open)
OPENS(open64)

#define OPENS_AT(name) \
    int name(int at, const char *path, int flags, ...) { \
        REAL(name); \
        mode_t mode = 0; \
        if (flags & (O_CREAT | O_TMPFILE)) { va_list rest; va_start(rest, flags); mode = va_arg(rest, mode_t); va_end(rest); } \
        if ((flags & O_CREAT) && is_below(path)) { int how = fault(); if (how == TEAR) die(); if (how) FAIL(how); } \
        return real(at, path, flags, mode); \
    }
OPENS_AT(openat)
OPENS_AT(openat64)
