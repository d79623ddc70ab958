/* The library itself: Python finds it as a module without contents, and calls its functions by ctypes. */
#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030b0000
#include <Python.h>

#include "kernels.h"

KERNEL int kernels_version(void)
{
    return 32; /* VERSION in library.py */
}

static struct PyModuleDef module = {PyModuleDef_HEAD_INIT, "_compiled", "Compiled kernels.", 0, NULL,
                                    NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__compiled(void)
{
    return PyModuleDef_Init(&module);
}
