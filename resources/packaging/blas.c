/* What OpenCV asks of BLAS and LAPACK, answered by the OpenBLAS that comes with NumPy.
 *
 * OpenCV's integers have 32 bits, NumPy's OpenBLAS has 64 and a name of its own for each function.
 * Numbers are widened on the way there; info, pivots and the like are narrowed on the way back.
 */

#include <stdint.h>
#include <stdlib.h>

typedef int32_t narrow;
typedef int64_t wide;

#define THEIRS(name) scipy_##name##_64_
#define WIDE(x) (&(wide){*(x)})

static wide *some(wide count)
{
    wide *made = malloc(sizeof(wide) * (count > 0 ? count : 1));
    if (!made)
        abort(); /* as OpenBLAS does itself */
    return made;
}

static wide least(const narrow *a, const narrow *b) { return *a < *b ? *a : *b; }

static void hand_back(narrow *to, wide *from, wide count)
{
    for (wide at = 0; at < count; at++)
        to[at] = (narrow)from[at];
    free(from);
}

#define GEMM(letter, value)                                                                     \
    void scipy_cblas_##letter##gemm64_(int, int, int, wide, wide, wide, value, const void *,     \
                                       wide, const void *, wide, value, void *, wide);           \
    void cblas_##letter##gemm(int order, int how_a, int how_b, narrow m, narrow n, narrow k,     \
                              value alpha, const void *a, narrow lda, const void *b, narrow ldb, \
                              value beta, void *c, narrow ldc)                                   \
    {                                                                                            \
        scipy_cblas_##letter##gemm64_(order, how_a, how_b, m, n, k, alpha, a, lda, b, ldb, beta, \
                                      c, ldc);                                                   \
    }

GEMM(s, float)
GEMM(d, double)
GEMM(c, const void *)
GEMM(z, const void *)

/* The size_t at the ends are the lengths of Fortran's characters. */
#define LAPACK(letter, real)                                                                      \
    void THEIRS(letter##gesv)(wide *, wide *, real *, wide *, wide *, real *, wide *, wide *);    \
    void letter##gesv_(narrow *n, narrow *columns, real *a, narrow *lda, narrow *pivots, real *b, \
                       narrow *ldb, narrow *info)                                                 \
    {                                                                                             \
        wide said, *wide_pivots = some(*n);                                                       \
        THEIRS(letter##gesv)                                                                      \
        (WIDE(n), WIDE(columns), a, WIDE(lda), wide_pivots, b, WIDE(ldb), &said);                 \
        *info = said;                                                                             \
        hand_back(pivots, wide_pivots, said < 0 ? 0 : *n);                                        \
    }                                                                                             \
    void THEIRS(letter##getrf)(wide *, wide *, real *, wide *, wide *, wide *);                   \
    void letter##getrf_(narrow *m, narrow *n, real *a, narrow *lda, narrow *pivots, narrow *info) \
    {                                                                                             \
        wide said, *wide_pivots = some(least(m, n));                                              \
        THEIRS(letter##getrf)(WIDE(m), WIDE(n), a, WIDE(lda), wide_pivots, &said);                \
        *info = said;                                                                             \
        hand_back(pivots, wide_pivots, said < 0 ? 0 : least(m, n));                               \
    }                                                                                             \
    void THEIRS(letter##posv)(char *, wide *, wide *, real *, wide *, real *, wide *, wide *,     \
                              size_t);                                                            \
    void letter##posv_(char *half, narrow *n, narrow *columns, real *a, narrow *lda, real *b,     \
                       narrow *ldb, narrow *info)                                                 \
    {                                                                                             \
        wide said;                                                                                \
        THEIRS(letter##posv)(half, WIDE(n), WIDE(columns), a, WIDE(lda), b, WIDE(ldb), &said, 1); \
        *info = said;                                                                             \
    }                                                                                             \
    void THEIRS(letter##potrf)(char *, wide *, real *, wide *, wide *, size_t);                   \
    void letter##potrf_(char *half, narrow *n, real *a, narrow *lda, narrow *info)                \
    {                                                                                             \
        wide said;                                                                                \
        THEIRS(letter##potrf)(half, WIDE(n), a, WIDE(lda), &said, 1);                             \
        *info = said;                                                                             \
    }                                                                                             \
    void THEIRS(letter##gels)(char *, wide *, wide *, wide *, real *, wide *, real *, wide *,     \
                              real *, wide *, wide *, size_t);                                    \
    void letter##gels_(char *how, narrow *m, narrow *n, narrow *columns, real *a, narrow *lda,    \
                       real *b, narrow *ldb, real *work, narrow *lwork, narrow *info)             \
    {                                                                                             \
        wide said;                                                                                \
        THEIRS(letter##gels)(how, WIDE(m), WIDE(n), WIDE(columns), a, WIDE(lda), b, WIDE(ldb),    \
                             work, WIDE(lwork), &said, 1);                                        \
        *info = said;                                                                             \
    }                                                                                             \
    void THEIRS(letter##geqrf)(wide *, wide *, real *, wide *, real *, real *, wide *, wide *);   \
    void letter##geqrf_(narrow *m, narrow *n, real *a, narrow *lda, real *tau, real *work,        \
                        narrow *lwork, narrow *info)                                              \
    {                                                                                             \
        wide said;                                                                                \
        THEIRS(letter##geqrf)(WIDE(m), WIDE(n), a, WIDE(lda), tau, work, WIDE(lwork), &said);     \
        *info = said;                                                                             \
    }                                                                                             \
    void THEIRS(letter##gesdd)(char *, wide *, wide *, real *, wide *, real *, real *, wide *,    \
                               real *, wide *, real *, wide *, wide *, wide *, size_t);           \
    void letter##gesdd_(char *how, narrow *m, narrow *n, real *a, narrow *lda, real *s, real *u,  \
                        narrow *ldu, real *vt, narrow *ldvt, real *work, narrow *lwork,           \
                        narrow *scratch, narrow *info)                                            \
    {                                                                                             \
        wide said, *wide_scratch = some(8 * least(m, n));                                         \
        (void)scratch;                                                                            \
        THEIRS(letter##gesdd)(how, WIDE(m), WIDE(n), a, WIDE(lda), s, u, WIDE(ldu), vt,           \
                              WIDE(ldvt), work, WIDE(lwork), wide_scratch, &said, 1);             \
        *info = said;                                                                             \
        free(wide_scratch);                                                                       \
    }

LAPACK(s, float)
LAPACK(d, double)

void THEIRS(dgeev)(char *, char *, wide *, double *, wide *, double *, double *, double *, wide *,
                   double *, wide *, double *, wide *, wide *, size_t, size_t);
void dgeev_(char *left, char *right, narrow *n, double *a, narrow *lda, double *re, double *im,
            double *vl, narrow *ldvl, double *vr, narrow *ldvr, double *work, narrow *lwork,
            narrow *info)
{
    wide said;
    THEIRS(dgeev)(left, right, WIDE(n), a, WIDE(lda), re, im, vl, WIDE(ldvl), vr, WIDE(ldvr), work,
                  WIDE(lwork), &said, 1, 1);
    *info = said;
}
