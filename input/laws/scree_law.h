/* SPDX-License-Identifier: BSD-3-Clause */
/* A strength law in a shared library: the interface between Scree and the library.
 *
 * A library has three procedures, and may have two more. They are called from several threads at
 * once, so they must not write variables outside of their arguments. doc/guide/own_law.md is the
 * manual. Fortran: scree_law.f90.
 *
 *    cc -O2 -ffp-contract=off -fPIC -shared -I FOLDER my_law.c -o my_law.so
 */
#ifndef SCREE_LAW_H
#define SCREE_LAW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this interface. A program with another version refuses the library. */
#define SCREE_LAW_INTERFACE 1

/* Components of a symmetric tensor. */
enum { SCREE_XX, SCREE_YY, SCREE_ZZ, SCREE_XY, SCREE_YZ, SCREE_XZ };

/* Functions whose bits are the same on all processors; those of libm differ between versions.
 * Each replaces its arguments in x. */
typedef struct scree_tools {
   void (*exponentials)(int64_t count, double *x);
   void (*logarithms)(int64_t count, double *x);
   void (*powers)(int64_t count, double exponent, double *x);
   void (*fast_powers)(int64_t count, double exponent, double *x); /* exp(exponent ln(x)) */
} scree_tools;

/* Particles of one call. Arrays have one number for each row, 0 to count - 1. */
typedef struct scree_rows {
   int64_t count;                    /* rows */
   double dt;                        /* time step [s]; 1e-100 for the stress of a state at rest */
   double shear;                     /* shear modulus of the material [Pa] */
   double bulk;                      /* bulk modulus of the reference state [Pa] */
   double density;                   /* density of the reference state [kg/m3] */
   const double *constants;          /* in the order of the declaration [SI] */
   /* xx, yy, zz, xy, yz, xz [Pa]. stress deviator: the elastic trial on entry, the deviator on
    * return. stress whole: the stress before the step, rotated, and the stress after it. */
   double *stress[6];
   const double *gradient[9];        /* dt du_k/dx_l in [k + 3 l], k and l 0 to 2 [1] */
   const double *pressure;           /* after the step; NULL with stress whole [Pa] */
   const double *volume;             /* after the step [m3] */
   const double *old_volume;         /* before the step [m3] */
   const double *mass;               /* [kg] */
   const double *energy;             /* internal energy, or NULL [J/kg] */
   const double *temperature;        /* before the step, or NULL [K] */
   const double *damage;             /* of the damage model, or NULL [1] */
   double *plastic_increment;        /* equivalent plastic strain of the step: out [1] */
   double *plastic_work;             /* work of the plastic flow: out, with work library only [J] */
   double *const *history;           /* [field][row], in the order of the declaration */
   const scree_tools *tools;
   int64_t error_row;                /* row of the error, -1: all rows: out */
   int32_t error;                    /* not 0: the run stops with this number: out */
   int32_t unused;
} scree_rows;

/* Strain increment of a row: xx, yy, zz, xy, yz, xz. Shear components are halves of the angles. */
static inline void scree_strain(const scree_rows *rows, int64_t row, double strain[6])
{
   strain[SCREE_XX] = rows->gradient[0][row];
   strain[SCREE_YY] = rows->gradient[4][row];
   strain[SCREE_ZZ] = rows->gradient[8][row];
   strain[SCREE_XY] = 0.5 * (rows->gradient[3][row] + rows->gradient[1][row]);
   strain[SCREE_YZ] = 0.5 * (rows->gradient[7][row] + rows->gradient[5][row]);
   strain[SCREE_XZ] = 0.5 * (rows->gradient[6][row] + rows->gradient[2][row]);
}

/* Returns SCREE_LAW_INTERFACE. */
int32_t scree_law_interface(void);

/* Text that declares the law, one statement a line:
 *
 *    law NAME
 *    stress deviator | whole        what the law returns; default: deviator
 *    flow plastic | none            default: plastic
 *    work scree | library           who computes plastic_increment and plastic_work; default: scree
 *    needs temperature              rows have a temperature
 *    needs energy                   rows have an internal energy
 *    constant NAME [UNIT] RANGE default NUMBER : meaning
 *    field NAME [UNIT] start NUMBER : meaning
 */
const char *scree_law_declaration(void);

/* Updates stress and history of the rows. */
void scree_law_update(scree_rows *rows);

/* Optional: 0 if the constants are valid, otherwise a message in at most length letters. */
int32_t scree_law_check(const double *constants, char *message, int64_t length);

/* Optional: the meaning of an error of the rows, or NULL. */
const char *scree_law_explain(int32_t error);

#ifdef __cplusplus
}
#endif

#endif
