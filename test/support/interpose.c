/* SPDX-License-Identifier: BSD-3-Clause */
/* Preloaded library that kills a program, or lets system calls fail, at a chosen call on files of one folder.
 *
 * Calls that change files below FAULT_FOLDER are counted from 1. FAULT_CALL is the number of the call, FAULT_ACTION is
 *    kill   SIGKILL before the call
 *    tear   half of the call, if it is a write, then SIGKILL
 *    N      this call and all later ones fail with error number N (closing and removing still work)
 * FAULT_NO_RESERVE lets fallocate fail as on a file system without it. FAULT_RANK restricts faults to one rank. The
 * number of calls is written to FAULT_COUNT at the end of the process. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

enum { most = 4096 };
static const char *folder;
static long counted, chosen;
static int action;                   /* error number, or -1: kill, -2: tear */
static char followed[most];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

#define REAL(type, name, ...) \
   static type (*real)(__VA_ARGS__); \
   if (!real) real = (type (*)(__VA_ARGS__)) dlsym(RTLD_NEXT, name)

__attribute__((constructor)) static void start(void)
{
   const char *call = getenv("FAULT_CALL"), *what = getenv("FAULT_ACTION"), *only = getenv("FAULT_RANK");
   const char *rank = getenv("OMPI_COMM_WORLD_RANK");
   folder = getenv("FAULT_FOLDER");
   if (!rank) rank = getenv("PMI_RANK");
   if (only && strcmp(only, rank ? rank : "0") != 0) call = NULL;
   chosen = call ? atol(call) : 0;
   action = !what || !strcmp(what, "kill") ? -1 : !strcmp(what, "tear") ? -2 : atoi(what);
}

__attribute__((destructor)) static void finish(void)
{
   const char *path = getenv("FAULT_COUNT");
   FILE *file;
   if (!path || !counted) return;
   folder = NULL;
   file = fopen(path, "w");
   if (!file) return;
   fprintf(file, "%ld\n", counted);
   fclose(file);
}

static int is_below(const char *path)
{
   char whole[2 * PATH_MAX];
   if (!folder || !path) return 0;
   if (path[0] == '/') return strncmp(path, folder, strlen(folder)) == 0;
   if (!getcwd(whole, PATH_MAX)) return 0;
   strcat(whole, "/");
   return strncmp(whole, folder, strlen(folder)) == 0;
}

static int is_followed(int file) { return file >= 0 && file < most && followed[file]; }

/* Count a call: 0 to go on, 1 to fail with errno set, 2 to make half of it and die. */
static int fault(int may_fail)
{
   long number;
   pthread_mutex_lock(&lock);
   number = ++counted;
   pthread_mutex_unlock(&lock);
   if (!chosen || number < chosen) return 0;
   if (action == -2) return 2;
   if (action == -1) raise(SIGKILL);
   if (!may_fail) return 0;
   errno = action;
   return 1;
}

static void die(void) { raise(SIGKILL); }

static int opened(int file, int writes)
{
   if (file >= 0 && file < most) followed[file] = (char) writes;
   return file;
}

#define OPEN(name) \
   int name(const char *path, int flags, ...) \
   { \
      mode_t mode = 0; int writes, hit = 0; \
      REAL(int, #name, const char *, int, ...); \
      if (flags & (O_CREAT | O_TMPFILE)) { va_list rest; va_start(rest, flags); mode = va_arg(rest, mode_t); va_end(rest); } \
      writes = (flags & O_ACCMODE) != O_RDONLY && is_below(path); \
      if (writes) hit = fault(flags & O_CREAT); \
      if (hit == 1) return -1; \
      if (hit == 2) die(); \
      return opened(real(path, flags, mode), writes); \
   }
OPEN(open)
OPEN(open64)

#define OPENAT(name) \
   int name(int where, const char *path, int flags, ...) \
   { \
      mode_t mode = 0; int writes, hit = 0; \
      REAL(int, #name, int, const char *, int, ...); \
      if (flags & (O_CREAT | O_TMPFILE)) { va_list rest; va_start(rest, flags); mode = va_arg(rest, mode_t); va_end(rest); } \
      writes = (flags & O_ACCMODE) != O_RDONLY && is_below(path); \
      if (writes) hit = fault(flags & O_CREAT); \
      if (hit == 1) return -1; \
      if (hit == 2) die(); \
      return opened(real(where, path, flags, mode), writes); \
   }
OPENAT(openat)
OPENAT(openat64)

#define CREAT(name) \
   int name(const char *path, mode_t mode) \
   { \
      int writes = is_below(path), hit = 0; \
      REAL(int, #name, const char *, mode_t); \
      if (writes) hit = fault(1); \
      if (hit == 1) return -1; \
      if (hit == 2) die(); \
      return opened(real(path, mode), writes); \
   }
CREAT(creat)
CREAT(creat64)

ssize_t write(int file, const void *data, size_t size)
{
   int hit = 0;
   REAL(ssize_t, "write", int, const void *, size_t);
   if (is_followed(file)) hit = fault(1);
   if (hit == 1) return -1;
   if (hit == 2) { if (real(file, data, size / 2) >= 0) die(); die(); }
   return real(file, data, size);
}

#define PWRITE(name) \
   ssize_t name(int file, const void *data, size_t size, off_t place) \
   { \
      int hit = 0; \
      REAL(ssize_t, #name, int, const void *, size_t, off_t); \
      if (is_followed(file)) hit = fault(1); \
      if (hit == 1) return -1; \
      if (hit == 2) { if (real(file, data, size / 2, place) >= 0) die(); die(); } \
      return real(file, data, size, place); \
   }
PWRITE(pwrite)
PWRITE(pwrite64)

ssize_t writev(int file, const struct iovec *parts, int count)
{
   int hit = 0;
   REAL(ssize_t, "writev", int, const struct iovec *, int);
   if (is_followed(file)) hit = fault(1);
   if (hit == 1) return -1;
   if (hit == 2) die();
   return real(file, parts, count);
}

#define PWRITEV(name) \
   ssize_t name(int file, const struct iovec *parts, int count, off_t place) \
   { \
      int hit = 0; \
      REAL(ssize_t, #name, int, const struct iovec *, int, off_t); \
      if (is_followed(file)) hit = fault(1); \
      if (hit == 1) return -1; \
      if (hit == 2) die(); \
      return real(file, parts, count, place); \
   }
PWRITEV(pwritev)
PWRITEV(pwritev64)

#define OF_FILE(name) \
   int name(int file) \
   { \
      int hit = 0; \
      REAL(int, #name, int); \
      if (is_followed(file)) hit = fault(1); \
      if (hit == 1) return -1; \
      if (hit == 2) die(); \
      return real(file); \
   }
OF_FILE(fsync)
OF_FILE(fdatasync)

#define LENGTH(name) \
   int name(int file, off_t size) \
   { \
      int hit = 0; \
      REAL(int, #name, int, off_t); \
      if (is_followed(file)) hit = fault(0); \
      if (hit == 2) die(); \
      return real(file, size); \
   }
LENGTH(ftruncate)
LENGTH(ftruncate64)

#define RESERVE(name) \
   int name(int file, int mode, off_t from, off_t size) \
   { \
      int hit = 0; \
      REAL(int, #name, int, int, off_t, off_t); \
      if (is_followed(file)) hit = fault(1); \
      if (hit == 1) return -1; \
      if (hit == 2) die(); \
      if (is_followed(file) && getenv("FAULT_NO_RESERVE")) { errno = EOPNOTSUPP; return -1; } \
      return real(file, mode, from, size); \
   }
RESERVE(fallocate)
RESERVE(fallocate64)

int close(int file)
{
   REAL(int, "close", int);
   if (is_followed(file)) { followed[file] = 0; if (fault(0) == 2) die(); }
   return real(file);
}

/* A descriptor that means another file from now on is followed if that file is. */
int dup2(int old, int new)
{
   REAL(int, "dup2", int, int);
   if (new >= 0 && new < most) followed[new] = (char) is_followed(old);
   return real(old, new);
}

#define OF_PATH(name, may_fail) \
   int name(const char *path) \
   { \
      int hit = 0; \
      REAL(int, #name, const char *); \
      if (is_below(path)) hit = fault(may_fail); \
      if (hit == 1) return -1; \
      if (hit == 2) die(); \
      return real(path); \
   }
OF_PATH(unlink, 0)
OF_PATH(rmdir, 0)

int mkdir(const char *path, mode_t mode)
{
   int hit = 0;
   REAL(int, "mkdir", const char *, mode_t);
   if (is_below(path)) hit = fault(1);
   if (hit == 1) return -1;
   if (hit == 2) die();
   return real(path, mode);
}

#define TRUNCATE(name) \
   int name(const char *path, off_t size) \
   { \
      REAL(int, #name, const char *, off_t); \
      if (is_below(path) && fault(0) == 2) die(); \
      return real(path, size); \
   }
TRUNCATE(truncate)
TRUNCATE(truncate64)

int rename(const char *old, const char *new)
{
   int hit = 0;
   REAL(int, "rename", const char *, const char *);
   if (is_below(old)) hit = fault(1);
   if (hit == 1) return -1;
   if (hit == 2) die();
   return real(old, new);
}
