// SPDX-License-Identifier: Apache-2.0
#include "cam_harmonics.h"
#include "cam_fix.h" // cam_sat_i32

/// Steps of the circle: entries of the cosine per turn.
enum { circle = 256, quarter = circle / 4 };

/// cos(2 pi i / 256) * 2^24, rounded to nearest
static const int32_t cosine_q24[quarter + 1] = {
    16777216, 16772163, 16757007, 16731757, 16696429, 16651044, 16595628, 16530216, 16454846,
    16369565, 16274424, 16169479, 16054795, 15930439, 15796488, 15653022, 15500126, 15337895,
    15166424, 14985817, 14796184, 14597637, 14390298, 14174291, 13949745, 13716797, 13475586,
    13226258, 12968963, 12703856, 12431097, 12150850, 11863283, 11568571, 11266890, 10958422,
    10643353, 10321873, 9994176,  9660458,  9320922,  8975771,  8625213,  8269459,  7908725,
    7543226,  7173184,  6798821,  6420363,  6038037,  5652074,  5262706,  4870169,  4474698,
    4076531,  3675909,  3273072,  2868265,  2461729,  2053710,  1644455,  1234209,  823219,
    411733,   0,
};

int32_t cam_cos_q24(uint32_t step)
{
    const uint32_t i = step % circle;
    const uint32_t in_half = i <= circle / 2u ? i : circle - i;
    return in_half <= quarter ? cosine_q24[in_half] : -cosine_q24[circle / 2u - in_half];
}

int32_t cam_sin_q24(uint32_t step)
{
    return cam_cos_q24(step + 3u * quarter);
}

cam_complex_t cam_harmonics_of(const int32_t *mean, uint32_t stride, uint32_t k)
{
    int64_t re = 0;
    int64_t im = 0;
    uint32_t step = k; // the middle of bin 0 is half a bin, step 1 of the circle
    for (uint32_t i = 0; i < cam_learn_bins; i++) {
        const int64_t value = mean[i * stride];
        re += value * cam_cos_q24(step);
        im -= value * cam_sin_q24(step);
        step += 2u * k;
    }
    const uint32_t shift = 24u + (k > 0u ? cam_learn_log2_bins - 1u : cam_learn_log2_bins);
    const int64_t half = INT64_C(1) << (shift - 1u);
    return (cam_complex_t){.re = cam_sat_i32((re + half) >> shift),
                           .im = k > 0u ? cam_sat_i32((im + half) >> shift) : 0};
}

cam_complex_t cam_harmonics_turned(cam_complex_t c, uint32_t k, uint32_t angle_q32)
{
    const uint32_t by_q32 = k * angle_q32;
    const uint32_t step = by_q32 >> 24;
    const int32_t part_q24 = (int32_t)(by_q32 & 0xFFFFFFu);
    const int64_t re_q24 = cam_cos_q24(step) +
                           (((int64_t)cam_cos_q24(step + 1u) - cam_cos_q24(step)) * part_q24 >> 24);
    const int64_t im_q24 = cam_sin_q24(step) +
                           (((int64_t)cam_sin_q24(step + 1u) - cam_sin_q24(step)) * part_q24 >> 24);
    const int64_t half = INT64_C(1) << 23;
    return (cam_complex_t){.re = cam_sat_i32((c.re * re_q24 - c.im * im_q24 + half) >> 24),
                           .im = cam_sat_i32((c.re * im_q24 + c.im * re_q24 + half) >> 24)};
}

/// The four parts of a sum that are even or odd in the angle and in the harmonic.
typedef struct {
    int64_t even_cos, odd_cos, even_sin, odd_sin;
} parts_t;

static parts_t parts_at(const cam_complex_t *c, uint32_t first, uint32_t i)
{
    parts_t p = {0};
    for (uint32_t k = first; k <= cam_harmonics_most; k++) {
        const int64_t by_cos = (int64_t)c[k - first].re * cam_cos_q24(k * i);
        const int64_t by_sin = (int64_t)c[k - first].im * -(int64_t)cam_sin_q24(k * i);
        if (k % 2u == 0u) {
            p.even_cos += by_cos;
            p.even_sin += by_sin;
        } else {
            p.odd_cos += by_cos;
            p.odd_sin += by_sin;
        }
    }
    return p;
}

/// Move a point towards a sum. @return whether it is there
static bool lead(int16_t *point, int64_t sum, uint32_t shift, int32_t most)
{
    const int64_t value = (sum + (INT64_C(1) << (shift - 1u))) >> shift;
    const int32_t target = (int32_t)cam_clamp_i64(value, -INT16_MAX, INT16_MAX);
    *point = (int16_t)cam_clamp_i32(target, *point - most, *point + most);
    return *point == target;
}

bool cam_harmonics_lead(int16_t *point, const cam_complex_t *c, uint32_t first, uint32_t down,
                        int32_t most)
{
    const uint32_t shift = 24u + down;
    bool is_there = true;
    for (uint32_t i = 0; i <= quarter; i++) {
        const parts_t p = parts_at(c, first, i);
        const int64_t even[2] = {p.even_cos + p.even_sin, p.even_cos - p.even_sin};
        const int64_t odd[2] = {p.odd_cos + p.odd_sin, p.odd_cos - p.odd_sin};
        is_there = lead(&point[i], even[0] + odd[0], shift, most) && is_there;
        if (i < quarter) { // the others are mirror images, those on the axes are their own
            is_there = lead(&point[circle / 2u + i], even[0] - odd[0], shift, most) && is_there;
        }
        if (i > 0u) {
            is_there = lead(&point[circle - i], even[1] + odd[1], shift, most) && is_there;
        }
        if (i > 0u && i < quarter) {
            is_there = lead(&point[circle / 2u - i], even[1] - odd[1], shift, most) && is_there;
        }
    }
    point[circle] = point[0];
    return is_there;
}
