// SPDX-License-Identifier: Apache-2.0
#include "cam_learning_inner.h"
#include "cam_fix.h" // cam_sat_i32
#include <stddef.h>  // size_t

enum { circle = 256, quarter = circle / 4 }; ///< steps of a turn

/// cos(2 pi i / 256) * 2^30, rounded to nearest
static const int32_t cosine_q30[circle] = {
    1073741824,  1073418433,  1072448455,  1070832474,  1068571464,  1065666786,  1062120190,
    1057933813,  1053110176,  1047652185,  1041563127,  1034846671,  1027506862,  1019548121,
    1010975242,  1001793390,  992008094,   981625251,   970651112,   959092290,   946955747,
    934248793,   920979082,   907154608,   892783698,   877875009,   862437520,   846480531,
    830013654,   813046808,   795590213,   777654384,   759250125,   740388522,   721080937,
    701339000,   681174602,   660599890,   639627258,   618269338,   596538995,   574449320,
    552013618,   529245404,   506158392,   482766489,   459083786,   435124548,   410903207,
    386434353,   361732726,   336813204,   311690799,   286380643,   260897982,   235258165,
    209476638,   183568930,   157550647,   131437462,   105245103,   78989349,    52686014,
    26350943,    0,           -26350943,   -52686014,   -78989349,   -105245103,  -131437462,
    -157550647,  -183568930,  -209476638,  -235258165,  -260897982,  -286380643,  -311690799,
    -336813204,  -361732726,  -386434353,  -410903207,  -435124548,  -459083786,  -482766489,
    -506158392,  -529245404,  -552013618,  -574449320,  -596538995,  -618269338,  -639627258,
    -660599890,  -681174602,  -701339000,  -721080937,  -740388522,  -759250125,  -777654384,
    -795590213,  -813046808,  -830013654,  -846480531,  -862437520,  -877875009,  -892783698,
    -907154608,  -920979082,  -934248793,  -946955747,  -959092290,  -970651112,  -981625251,
    -992008094,  -1001793390, -1010975242, -1019548121, -1027506862, -1034846671, -1041563127,
    -1047652185, -1053110176, -1057933813, -1062120190, -1065666786, -1068571464, -1070832474,
    -1072448455, -1073418433, -1073741824, -1073418433, -1072448455, -1070832474, -1068571464,
    -1065666786, -1062120190, -1057933813, -1053110176, -1047652185, -1041563127, -1034846671,
    -1027506862, -1019548121, -1010975242, -1001793390, -992008094,  -981625251,  -970651112,
    -959092290,  -946955747,  -934248793,  -920979082,  -907154608,  -892783698,  -877875009,
    -862437520,  -846480531,  -830013654,  -813046808,  -795590213,  -777654384,  -759250125,
    -740388522,  -721080937,  -701339000,  -681174602,  -660599890,  -639627258,  -618269338,
    -596538995,  -574449320,  -552013618,  -529245404,  -506158392,  -482766489,  -459083786,
    -435124548,  -410903207,  -386434353,  -361732726,  -336813204,  -311690799,  -286380643,
    -260897982,  -235258165,  -209476638,  -183568930,  -157550647,  -131437462,  -105245103,
    -78989349,   -52686014,   -26350943,   0,           26350943,    52686014,    78989349,
    105245103,   131437462,   157550647,   183568930,   209476638,   235258165,   260897982,
    286380643,   311690799,   336813204,   361732726,   386434353,   410903207,   435124548,
    459083786,   482766489,   506158392,   529245404,   552013618,   574449320,   596538995,
    618269338,   639627258,   660599890,   681174602,   701339000,   721080937,   740388522,
    759250125,   777654384,   795590213,   813046808,   830013654,   846480531,   862437520,
    877875009,   892783698,   907154608,   920979082,   934248793,   946955747,   959092290,
    970651112,   981625251,   992008094,   1001793390,  1010975242,  1019548121,  1027506862,
    1034846671,  1041563127,  1047652185,  1053110176,  1057933813,  1062120190,  1065666786,
    1068571464,  1070832474,  1072448455,  1073418433,
};

int32_t cam_cos_q24(uint32_t step)
{
    return cosine_q30[step % circle] >> 6;
}

int32_t cam_sin_q24(uint32_t step)
{
    return cosine_q30[(step + 3u * quarter) % circle] >> 6;
}

cam_complex_t cam_harmonics_of(const int32_t *mean, uint32_t stride, uint32_t k)
{
    int64_t re = 0;
    int64_t im = 0;
    uint32_t step = k; // the middle of bin 0 is half a bin, step 1 of the circle
    for (uint32_t i = 0; i < cam_turn_bins_n; i++) {
        const int64_t value = mean[(size_t)i * stride];
        re += value * cam_cos_q24(step);
        im -= value * cam_sin_q24(step);
        step += 2u * k;
    }
    const uint32_t shift = 24u + (k > 0u ? cam_turn_bins_log2 - 1u : cam_turn_bins_log2);
    const int64_t half = INT64_C(1) << (shift - 1u);
    return (cam_complex_t){.re = cam_sat_i32((re + half) >> shift),
                           .im = k > 0u ? cam_sat_i32((im + half) >> shift) : 0};
}

cam_complex_t cam_harmonics_rotated(cam_complex_t c, uint32_t k, uint32_t angle_q32)
{
    const uint32_t turn_q32 = k * angle_q32;
    const uint32_t step = turn_q32 >> 24;
    const int32_t part_q24 = (int32_t)(turn_q32 & 0xFFFFFFu);
    const int64_t re_q24 = cam_cos_q24(step) +
                           (((int64_t)cam_cos_q24(step + 1u) - cam_cos_q24(step)) * part_q24 >> 24);
    const int64_t im_q24 = cam_sin_q24(step) +
                           (((int64_t)cam_sin_q24(step + 1u) - cam_sin_q24(step)) * part_q24 >> 24);
    const int64_t half = INT64_C(1) << 23;
    return (cam_complex_t){.re = cam_sat_i32((c.re * re_q24 - c.im * im_q24 + half) >> 24),
                           .im = cam_sat_i32((c.re * im_q24 + c.im * re_q24 + half) >> 24)};
}

/// Left shift of a harmonic before the multiplication, and of the product.
enum { shift_in = 7, shift_out = shift_in + 30 - 32 };

/// Cosine and sine part of a sum: even and odd in the angle.
typedef struct {
    int32_t cos, sin;
} parts_t;

/// @return sum of every second harmonic, starting at `from`, at point i, shifted by shift_out
static parts_t parts_at(const cam_complex_t *c, uint32_t from, uint32_t i)
{
    parts_t p = {0};
    uint32_t step = from * i;
    for (uint32_t k = from; k <= cam_ilc_harmonics; k += 2u) {
        const int32_t cosine = cosine_q30[step % circle];
        const int32_t minus_sine = cosine_q30[(step + quarter) % circle];
        p.cos = cam_mulhi_add(p.cos, c[k].re * (1 << shift_in), cosine);
        p.sin = cam_mulhi_add(p.sin, c[k].im * (1 << shift_in), minus_sine);
        step += 2u * i;
    }
    return p;
}

/// Move a point towards a sum. @return whether it has reached it
static bool slew_point(int16_t *point, int32_t sum, uint32_t shift, int32_t most)
{
    const int32_t value = (sum + (1 << (shift - 1u))) >> shift;
    const int32_t target = cam_clamp_i32(value, -INT16_MAX, INT16_MAX);
    *point = (int16_t)cam_clamp_i32(target, *point - most, *point + most);
    return *point == target;
}

bool cam_harmonics_slew(int16_t *point, const cam_complex_t *c, uint32_t down, int32_t most)
{
    const uint32_t shift = shift_out + down;
    bool is_done = true;
    for (uint32_t i = 0; i <= quarter; i++) {
        const parts_t even = parts_at(c, 0, i);
        const parts_t odd = parts_at(c, 1, i);
        const uint32_t at[4] = {i, circle / 2u + i, circle - i, circle / 2u - i};
        const int32_t here[2] = {even.cos + even.sin, even.cos - even.sin};
        const int32_t more[2] = {odd.cos + odd.sin, odd.cos - odd.sin};
        const int32_t sum[4] = {here[0] + more[0], here[0] - more[0], here[1] + more[1],
                                here[1] - more[1]};
        for (uint32_t j = 0; j < 4u; j++) {
            // On an axis a point is its own mirror image.
            const bool is_same = (i == 0u && j >= 2u) || (i == quarter && (j & 1u) != 0u);
            is_done = (is_same || slew_point(&point[at[j]], sum[j], shift, most)) && is_done;
        }
    }
    point[circle] = point[0];
    point[circle + 1] = point[1];
    return is_done;
}
