/* SPDX-License-Identifier: BSD-3-Clause */
/* Law of Johnson and Cook as a library: the same bits as strength_model = 'johnson_cook' with
 * &effects rate and thermal.
 *
 *    cc -O3 -march=native -fno-math-errno -fno-trapping-math -ffp-contract=off -fPIC -shared \
 *       johnson_cook.c -o johnson_cook.so
 *
 * The first four options make vectors of the loops and change no bits.
 *
 * The plastic increment x of a step solves trial - 3 G x = Y(x) with the yield stress Y = (A + B
 * (ep + x)**n) (1 + C ln(x/(rate dt))) (1 - T**m), by Newton's method within a bracket. Rows are
 * solved in groups, so that the compiler makes vectors of them. */
#include <math.h>
#include "scree_law.h"

enum { A, B, N, C, RATE, M, T_REF, T_MELT };

static const char declaration[] =
   "law johnson_cook\n"
   "work library\n"
   "needs temperature\n"
   "constant A [Pa] > 0 : static yield stress\n"
   "constant B [Pa] >= 0 : hardening\n"
   "constant n [1] >= 0 : exponent of the plastic strain\n"
   "constant C [1] >= 0 default 0 : rate dependence\n"
   "constant rate [1/s] > 0 default 1 : strain rate of the static yield stress\n"
   "constant m [1] > 0 default 1 : exponent of the temperature\n"
   "constant t_ref [K] >= 0 default 293 : full strength up to here\n"
   "constant t_melt [K] > 0 : no strength from here\n"
   "field plastic_strain [1] : equivalent plastic strain\n";

enum { LANES = 64 };
static const double tiny = 2.2250738585072014e-308, least = 1.0e-100, unbounded = 1.0e200;

typedef struct lanes {
   int count;                        /* rows that may flow */
   int filled;                       /* the same up to a multiple of 8, so that vectors are full */
   int place[LANES];
   double trial[LANES], fixed[LANES], amplitude[LANES], argument[LANES], x[LANES], limit[LANES],
      lower[LANES], upper[LANES], factor[LANES], tilt[LANES], going[LANES], base[LANES],
      hardening[LANES];
} lanes;

static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }

int32_t scree_law_interface(void) { return SCREE_LAW_INTERFACE; }

const char *scree_law_declaration(void) { return declaration; }

int32_t scree_law_check(const double *c, char *message, int64_t length)
{
   const char *text = "t_melt must be above t_ref";
   if (c[T_MELT] > c[T_REF])
      return 0;
   for (int64_t i = 0; i < length - 1 && *text; i++)
      *message++ = *text++;
   *message = 0;
   return 1;
}

/* amplitude base**n */
static void raise(lanes *l, double n, const scree_tools *tools)
{
   for (int i = 0; i < l->filled; i++)
      l->hardening[i] = l->base[i];
   tools->fast_powers(l->filled, n, l->hardening);
   for (int i = 0; i < l->filled; i++)
      l->hardening[i] = l->amplitude[i] * l->hardening[i];
}

/* Increment of linear hardening at the initial slope. */
static void start(lanes *l, double n, double stiffness)
{
   for (int i = 0; i < l->filled; i++) {
      double limit = smaller(l->fixed[i] + l->hardening[i], unbounded);
      double excess = larger(l->trial[i] - limit, 0.0);
      int flows = (excess > 0.0) & (limit > 0.0);
      double slope = n * l->hardening[i] / larger(l->argument[i], least);
      slope = (l->argument[i] > 0.0) & (limit < unbounded) ? slope : 0.0;
      slope = larger(excess / (stiffness + slope), least);
      l->going[i] = flows ? 1.0 : 0.0;
      l->limit[i] = smaller(limit, l->trial[i]);
      l->lower[i] = 0.0;
      l->upper[i] = excess / stiffness;
      l->x[i] = flows ? slope : 0.0;
      l->factor[i] = 1.0;
      l->tilt[i] = 0.0;
   }
}

/* Factor of the rate and its derivative. */
static void find_rate(lanes *l, double coefficient, double rest, const scree_tools *tools)
{
   for (int i = 0; i < l->filled; i++)
      l->factor[i] = larger(l->x[i] / rest, 1.0);
   tools->logarithms(l->filled, l->factor);
   for (int i = 0; i < l->filled; i++) {
      double tilt = l->x[i] > rest ? coefficient : 0.0;
      l->factor[i] = 1.0 + coefficient * l->factor[i];
      l->tilt[i] = tilt / larger(l->x[i], tiny);
   }
}

/* One step of Newton's method. A lane that has converged does not change. */
static void improve(lanes *l, double n, double stiffness, double rest)
{
   const double tolerance = 1.0e-12, brief = 0.25, back = 1.0 / 128.0;
   for (int i = 0; i < l->filled; i++) {
      double x = l->x[i], base = larger(l->base[i], least), factor = l->factor[i];
      double at_rest = smaller(l->fixed[i] + l->hardening[i], unbounded);
      double slope = (at_rest < unbounded ? n * l->hardening[i] : 0.0) / base;
      double limit = factor * at_rest;
      double curvature = factor * slope * fabs(1.0 - n) / base
         + l->tilt[i] * (2.0 * slope + at_rest / larger(x, least));
      slope = l->tilt[i] * at_rest + factor * slope;
      double residual = l->trial[i] - stiffness * x - limit;
      double enough = tolerance * limit;
      double right = fabs(residual) <= enough + 4.0 * 2.220446049250313e-16 * l->trial[i] ? 1.0 : 0.0;
      double lower = residual > 0.0 ? x : l->lower[i];
      double upper = residual > 0.0 ? l->upper[i] : x;
      double change = residual / (stiffness + slope);
      double next = x + change;
      double margin = at_rest < unbounded ? unbounded * factor - (limit + slope * change) : residual;
      margin = smaller(margin, (x - rest) * (next - rest));
      margin = smaller(margin, brief * x - fabs(change));
      margin = smaller(margin, enough - 2.0 * curvature * change * change);
      double smooth = margin >= 0.0 ? 1.0 - right : 0.0;
      smooth = smaller(next - lower, upper - next) > 0.0 ? smooth : 0.0;
      margin = next - lower;
      next = next < upper ? next : 0.5 * (lower + upper);
      next = margin > 0.0 ? next : lower + back * (upper - lower);
      limit = limit + smooth * slope * change;
      l->limit[i] = l->going[i] > 0.0 ? limit : l->limit[i];
      l->x[i] = l->going[i] * (1.0 - right) > 0.0 ? next : x;
      l->lower[i] = lower;
      l->upper[i] = upper;
      l->going[i] = l->going[i] * (1.0 - right) * (1.0 - smooth);
   }
}

/* Plastic increments and yield stresses of a group. */
static void solve(lanes *l, const double *c, double stiffness, double dt, const scree_tools *tools)
{
   double rest = c[C] > 0.0 ? dt * c[RATE] : 0.0, going = 1.0;

   l->filled = 8 * ((l->count + 7) / 8);
   for (int i = l->count; i < l->filled; i++) {
      l->trial[i] = l->trial[0];
      l->fixed[i] = l->fixed[0];
      l->amplitude[i] = l->amplitude[0];
      l->argument[i] = l->argument[0];
   }
   for (int i = 0; i < l->filled; i++)
      l->base[i] = l->argument[i];
   raise(l, c[N], tools);
   start(l, c[N], stiffness);
   for (int iteration = 0; iteration < 200; iteration++) {
      going = 0.0;
      for (int i = 0; i < l->filled; i++)
         going = larger(going, l->going[i]);
      if (!(going > 0.0))
         return;
      for (int i = 0; i < l->filled; i++)
         l->base[i] = l->argument[i] + l->x[i];
      raise(l, c[N], tools);
      if (c[C] > 0.0)
         find_rate(l, c[C], rest, tools);
      improve(l, c[N], stiffness, rest);
   }
}

/* Trial deviator times strain increment. */
static double trial_work(const scree_rows *r, int64_t i)
{
   return r->stress[0][i] * r->gradient[0][i] + r->stress[1][i] * r->gradient[4][i]
      + r->stress[2][i] * r->gradient[8][i]
      + r->stress[3][i] * (r->gradient[1][i] + r->gradient[3][i])
      + r->stress[4][i] * (r->gradient[5][i] + r->gradient[7][i])
      + r->stress[5][i] * (r->gradient[2][i] + r->gradient[6][i]);
}

/* Stress, work and plastic strain of the rows of a group. */
static void move_results(const lanes *l, scree_rows *r, int64_t offset)
{
   for (int i = 0; i < l->count; i++) {
      int64_t k = offset + l->place[i];
      double scaling = l->limit[i] / l->trial[i];
      double shear = 3.0 * r->shear / 3.0;
      double work = 0.5 * (l->trial[i] + l->limit[i])
         - 1.5 * shear * trial_work(r, k) / larger(l->trial[i], tiny);
      r->plastic_increment[k] = l->x[i];
      r->plastic_work[k] = r->volume[k] * (l->x[i] * larger(0.0, work));
      r->history[0][k] = r->history[0][k] + l->x[i];
      for (int component = 0; component < 6; component++)
         r->stress[component][k] = scaling * r->stress[component][k];
   }
}

/* Equivalent stresses and homologous temperatures of a group; how many may flow. */
static int find_trial(const scree_rows *r, int64_t offset, int rows, double *mises, double *warmth)
{
   const double *c = r->constants;
   const double bound = c[M] >= 1.0 ? c[A] : 0.0, factor = 1.0 / (c[T_MELT] - c[T_REF]);
   const double *xx = r->stress[SCREE_XX] + offset, *yy = r->stress[SCREE_YY] + offset,
      *zz = r->stress[SCREE_ZZ] + offset, *xy = r->stress[SCREE_XY] + offset,
      *yz = r->stress[SCREE_YZ] + offset, *xz = r->stress[SCREE_XZ] + offset,
      *temperature = r->temperature + offset;
   double above = 0.0, t_ref = c[T_REF];

   for (int n = 0; n < rows; n++) {
      mises[n] = sqrt(1.5 * (xx[n] * xx[n] + yy[n] * yy[n] + zz[n] * zz[n]
         + 2.0 * (xy[n] * xy[n] + yz[n] * yz[n] + xz[n] * xz[n])));
      warmth[n] = smaller(larger((temperature[n] - t_ref) * factor, 0.0), 1.0);
   }
   for (int n = 0; n < rows; n++)
      above = larger(above, mises[n] - bound * (1.0 - warmth[n]));
   return above > 0.0;
}

void scree_law_update(scree_rows *r)
{
   const double *c = r->constants;
   const double bound = c[M] >= 1.0 ? c[A] : 0.0;
   double mises[LANES], warmth[LANES];
   lanes l;

   for (int64_t offset = 0; offset < r->count; offset += LANES) {
      int rows = (int)(r->count - offset < LANES ? r->count - offset : LANES);
      if (!find_trial(r, offset, rows, mises, warmth))
         continue;
      l.count = 0;
      for (int n = 0; n < rows; n++) {
         if (!(mises[n] > bound * (1.0 - warmth[n])))
            continue;
         l.place[l.count] = n;
         l.trial[l.count] = mises[n];
         l.argument[l.count] = r->history[0][offset + n];
         l.factor[l.count] = warmth[n];
         l.count++;
      }
      if (l.count == 0)
         continue;
      if (c[M] != 1.0)
         r->tools->fast_powers(l.count, c[M], l.factor);
      for (int i = 0; i < l.count; i++) {
         l.fixed[i] = c[A] * (1.0 - l.factor[i]);
         l.amplitude[i] = c[B] * (1.0 - l.factor[i]);
      }
      solve(&l, c, 3.0 * r->shear, r->dt, r->tools);
      move_results(&l, r, offset);
   }
}
