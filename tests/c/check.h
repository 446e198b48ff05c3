#ifndef INHABIT_TESTS_CHECK_H
#define INHABIT_TESTS_CHECK_H
#include <stdio.h>
#include <stdlib.h>

/* Ends the test where `truth` is none. */
#define CHECK(truth)                                                                                        \
  do {                                                                                                      \
    if (!(truth)) {                                                                                         \
      fprintf(stderr, "%s:%d: not so: %s; the last error: %s\n", __FILE__, __LINE__, #truth, LAST_ERROR()); \
      exit(1);                                                                                              \
    }                                                                                                       \
  } while (0)
#endif
