/* SPDX-License-Identifier: BSD-3-Clause */
/* Plasticity with saturating hardening (E. Voce, J. Inst. Met. 74 (1948) 537): the yield stress is
 * Y = Y0 + R, and R grows by b (Q - R) per plastic strain. */
#include <math.h>
#include "scree_law.h"

enum { Y0, Q, RATE };                 /* constants and fields in the order of the declaration */
enum { R };

int32_t scree_law_interface(void)
{
   return SCREE_LAW_INTERFACE;
}

const char *scree_law_declaration(void)
{
   return "law voce\n"
          "constant Y0 [Pa] > 0 : yield stress at the start\n"
          "constant Q [Pa] >= 0 : greatest increase of the yield stress\n"
          "constant b [1] >= 0 default 10 : rate of its saturation\n"
          "field voce_r [Pa] : increase of the yield stress\n";
}

void scree_law_update(scree_rows *rows)
{
   const double *c = rows->constants;

   for (int64_t i = 0; i < rows->count; i++) {
      double s[6];
      for (int n = 0; n < 6; n++)
         s[n] = rows->stress[n][i];
      double mises = sqrt(1.5 * (s[SCREE_XX] * s[SCREE_XX] + s[SCREE_YY] * s[SCREE_YY]
         + s[SCREE_ZZ] * s[SCREE_ZZ] + 2.0 * (s[SCREE_XY] * s[SCREE_XY]
         + s[SCREE_YZ] * s[SCREE_YZ] + s[SCREE_XZ] * s[SCREE_XZ])));
      double yield = c[Y0] + rows->history[R][i];
      if (mises <= yield)
         continue;
      double slope = c[RATE] * (c[Q] - rows->history[R][i]);
      double flow = (mises - yield) / (3.0 * rows->shear + slope);
      double scaling = (yield + slope * flow) / mises;
      for (int n = 0; n < 6; n++)
         rows->stress[n][i] = scaling * s[n];
      rows->history[R][i] += slope * flow;
   }
}
