// SPDX-License-Identifier: Apache-2.0
// Writes the inputs that a campaign begins with: real tables, sessions and messages, made by code
// so that they follow the formats.
#include "cam_recorder.h"
#include "cam_param.h"
#include "fixture_image.h"
#include "fixture_newer.h"
#include "fixture_part.h"
#include "fixture_random.h"
#include "fixture_shaft.h"
#include "fuzz_draw.h"
#include "fuzz_expect.h"
#include "fuzz_rig.h"
#include "fuzz_mutate.h"
#include <string.h>
#include <sys/stat.h> // mkdir

enum { most_path = 512, cut_head = 16, session_order = 4, can_order = 12 };

static const char *folder;

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size)
{
    (void)data;
    (void)max_size;
    return size;
}

static void put(const char *target, const char *name, const void *bytes, size_t n)
{
    char path[most_path];
    (void)snprintf(path, sizeof path, "%s/%s", folder, target);
    (void)mkdir(path, 0777);
    (void)snprintf(path, sizeof path, "%s/%s/%s", folder, target, name);
    FILE *file = fopen(path, "wb");
    FUZZ_EXPECT(file != NULL && fwrite(bytes, 1, n, file) == n && fclose(file) == 0, "%s", path);
}

/// An image for its check, and the same to be cut at each rate.
static void put_image(const char *name, const fixture_image_t *image)
{
    static uint8_t cut[cut_head + 8192];
    put("table", name, image->bytes, image->size);
    for (uint32_t rate = 0; rate < 3u && image->size <= 8192u; rate++) {
        char rated[64];
        const uint8_t head[cut_head] = {(uint8_t)rate, 120, 0, 0, 2, 100, 0, 0, 4, 100, 0, 0};
        memcpy(cut, head, sizeof head);
        memcpy(cut + cut_head, image->bytes, image->size);
        (void)snprintf(rated, sizeof rated, "%s_%u", name, (unsigned)rate);
        put("cut", rated, cut, cut_head + image->size);
    }
}

static void way_of(double z_nm, double y[3])
{
    y[0] = z_nm * 1e-3;
    y[1] = 1e-3;
    y[2] = 0.0;
}

static void put_images(void)
{
    static fixture_image_t image;
    fixture_part_t few = fixture_part_short();
    few.n_slices = 3;
    few.log2_knots = 4;
    const fixture_part_t parts[] = {fixture_part_smallest(), few, fixture_part_modulated(),
                                    fixture_part_swung()};
    static const char *const names[] = {"smallest", "few", "modulated", "swung"};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        fixture_image_make(&image, &parts[i]);
        put_image(names[i], &image);
    }
    fixture_image_make(&image, &few);
    const fixture_pass_t passes[] = {{100000, 100000, 1000000, 0}, {0, 50000, 1200000, 0}};
    fixture_newer_passes(&image, passes, 2);
    put_image("passes", &image);
    fixture_image_make(&image, &few);
    fixture_newer_way(&image, way_of, 8, 4);
    put_image("way", &image);
    const size_t path = fixture_image_in(fixture_newer_last(&image), fixture_in_path);
    fixture_image_put(&image, path, 1u);
    fixture_image_seal(&image);
    put_image("stations", &image);
    const fixture_shaft_t shaft = fixture_shaft_three();
    fixture_shaft_make(&image, &shaft);
    put_image("shaft", &image);
}

/// A session: what the operator does from a start on, with pauses.
static void put_session(const char *name, uint8_t start, const uint8_t (*orders)[session_order],
                        size_t n)
{
    uint8_t bytes[256] = {start, strncmp(name, "pressed", 7) == 0, strncmp(name, "wild", 4) == 0,
                          strncmp(name, "forced", 6) == 0};
    memcpy(bytes + 4, orders, n * session_order);
    put("session", name, bytes, 4 + n * session_order);
}

#define ALL(orders) orders, sizeof(orders) / sizeof((orders)[0])

static void put_sessions(void)
{
    // Order, its kind, a number of two bytes: 0 wait, 2 command, 3 parameter, 4 fault, 5 sense.
    static const uint8_t whole_cut[][4] = {{10, 0, 0, 0}, {0, 0, 250, 0}, {10, 2, 0, 0},
                                           {0, 0, 80, 2}, {0, 0, 80, 2},  {0, 0, 80, 2},
                                           {0, 0, 80, 2}};
    static const uint8_t held[][4] = {{0, 0, 20, 0}, {10, 11, 0, 0}, {0, 0, 200, 0},
                                      {11, 0, 0, 4}, {10, 12, 0, 0}, {0, 0, 200, 0}};
    static const uint8_t stopped[][4] = {{0, 0, 20, 0}, {4, 0, 0, 255}, {0, 0, 200, 1},
                                         {4, 14, 0, 0}, {10, 4, 0, 0},  {0, 0, 20, 0},
                                         {10, 0, 0, 0}, {0, 0, 200, 1}};
    static const uint8_t by_hand[][4] = {{10, 23, 0, 16}, {7, 0, 100, 0}, {10, 24, 0, 8},
                                         {7, 0, 100, 0},  {5, 7, 10, 0},  {10, 25, 0, 0},
                                         {7, 0, 199, 0},  {10, 1, 0, 0},  {0, 0, 100, 0}};
    static const uint8_t weak[][4] = {{4, 8, 0, 2}, {0, 0, 200, 0}, {4, 2, 0, 255}, {0, 0, 0, 2}};
    static const uint8_t wild[][4] = {{11, 128, 0, 65}, {11, 129, 0, 65}, {11, 130, 0, 66},
                                      {10, 2, 0, 0},    {0, 0, 80, 2},    {12, 0, 0, 255},
                                      {0, 0, 80, 2}};
    static const uint8_t pressed[][4] = {{4, 12, 0, 0},   {10, 0, 0, 0}, {0, 0, 200, 1},
                                         {12, 0, 0, 255}, {4, 14, 0, 0}, {0, 0, 0, 2},
                                         {10, 4, 0, 0},   {4, 12, 0, 0}, {10, 6, 0, 0}};
    // Order 14: X is clear of the part, or U plays a wave. Parameter 12: a rehearsal of 8 turns.
    static const uint8_t forced[][4] = {
        {14, 254, 0, 0}, {11, 12, 8, 192}, {10, 0, 0, 0},  {0, 0, 80, 2},  {0, 0, 80, 2},
        {14, 254, 0, 0}, {7, 0, 199, 0},   {7, 0, 199, 0}, {7, 0, 199, 0}, {10, 3, 0, 0},
        {0, 0, 80, 2},   {10, 2, 0, 0},    {0, 0, 80, 2}};
#define NAMED(orders, start)                                                                       \
    {                                                                                              \
#orders, orders, sizeof(orders) / sizeof((orders)[0]), start                               \
    }
    static const struct {
        const char *name;
        const uint8_t (*orders)[session_order];
        size_t n;
        uint8_t start;
    } sessions[] = {NAMED(whole_cut, 0), NAMED(held, 8), NAMED(stopped, 8), NAMED(by_hand, 12),
                    NAMED(weak, 8),      NAMED(wild, 4), NAMED(pressed, 0), NAMED(forced, 0)};
#undef NAMED
    for (uint32_t i = 0; i < 4u * fuzz_rig_n_parts * 8u; i++) {
        const uint32_t rate = i % 4u;
        const uint32_t part = i / 4u % fuzz_rig_n_parts;
        const uint32_t which = i / 4u / fuzz_rig_n_parts;
        char name[64];
        (void)snprintf(name, sizeof name, "%s_%u_%u", sessions[which].name, rate, part);
        put_session(name, (uint8_t)(rate + 16u * part + sessions[which].start),
                    sessions[which].orders, sessions[which].n);
    }
}

static void put_kind(const char *name, const char *kind, const uint8_t *bytes, size_t n)
{
    char path[64];
    (void)snprintf(path, sizeof path, "%s_%s_%u", name, kind, (unsigned)bytes[0]);
    put("machine", path, bytes, 4 + fuzz_draw_bytes + n * session_order);
}

/// What is done with a machine at a rate: one of the defaults, one with a slow drive of U in a
/// short stroke (85 Hz, damping 0.7), a fast one whose every ramp is short, and that with a soft
/// drive.
static void put_machine(const char *name, uint8_t rate, const uint8_t (*orders)[session_order],
                        size_t n)
{
    static const struct {
        cam_param_id_t id;
        int32_t value;
    } fast[] = {
        {cam_param_u_acceleration_mm_per_s2, 20000},
        {cam_param_x_speed_um_per_s, 1000000},
        {cam_param_x_acceleration_mm_per_s2, 300000},
        {cam_param_z_speed_um_per_s, 1000000},
        {cam_param_z_acceleration_mm_per_s2, 300000},
        {cam_param_engage_turns, 1},
        {cam_param_disengage_turns, 1},
        {cam_param_feed_ramp_turns, 1},
        {cam_param_u_jog_um_per_s, 100000},
        {cam_param_x_jog_um_per_s, 300000},
        {cam_param_z_jog_um_per_s, 300000},
        {cam_param_x_low_nm, 45000000},
        {cam_param_x_high_nm, 50000000},
        {cam_param_z_low_nm, -1000000},
        {cam_param_z_high_nm, 2000000},
        {cam_param_spindle_limit_mrpm, 60000000},
        {cam_param_spindle_acceleration_mrad_per_s2, 1000000000},
    };
    uint8_t bytes[256] = {rate, 0, 230, 0};
    uint8_t *const drawn = bytes + 4;
    uint8_t plain[fuzz_draw_bytes] = {0};
    memcpy(drawn + fuzz_draw_bytes, orders, n * session_order);
    put_kind(name, "plain", bytes, n);
    fuzz_draw_write(drawn, cam_param_u_stroke_nm, 750000);
    fuzz_draw_write(drawn, cam_param_k1_ns, 2621000);
    fuzz_draw_write(drawn, cam_param_k2_us2, 0.51);
    put_kind(name, "slow", bytes, n);
    memcpy(drawn, plain, sizeof plain);
    for (size_t i = 0; i < sizeof fast / sizeof fast[0]; i++) {
        fuzz_draw_write(drawn, fast[i].id, fast[i].value);
    }
    put_kind(name, "fast", bytes, n);
    fuzz_draw_write(drawn, cam_param_u_stroke_nm, 900000);
    fuzz_draw_write(drawn, cam_param_k1_ns, 400000);
    put_kind(name, "soft", bytes, n);
}

static void put_machines(void)
{
    // Order, its kind, a number: 0 wait, 3 await, 4 mishap, 5 jog on, 6 the usual and await.
    static const uint8_t cut[][4] = {{14, 0, 0, 255}, {14, 0, 0, 255}, {14, 0, 0, 255},
                                     {3, 0, 0, 255},  {3, 0, 0, 255},  {3, 0, 0, 255},
                                     {0, 0, 250, 0}};
    static const uint8_t stopped[][4] = {
        {14, 0, 0, 255}, {14, 0, 0, 255}, {14, 0, 0, 255}, {3, 0, 0, 255}, {0, 0, 44, 1},
        {12, 0, 0, 128}, {3, 0, 0, 255},  {12, 6, 0, 0},   {14, 0, 1, 0},  {14, 0, 0, 255}};
    static const uint8_t jogged[][4] = {{10, 6, 0, 0},    {13, 0, 31, 255},   {13, 128, 31, 255},
                                        {13, 1, 31, 255}, {13, 129, 31, 255}, {13, 2, 31, 255},
                                        {12, 0, 0, 128},  {3, 0, 0, 255}};
    for (uint8_t rate = 0; rate < (uint8_t)fuzz_rig_n_rates; rate++) {
        put_machine("cut", rate, ALL(cut));
        put_machine("stopped", rate, ALL(stopped));
        put_machine("jogged", rate, ALL(jogged));
    }
}

/// Every command in every start, some of them in one input.
static void put_frames(void)
{
    enum { n_commands = 72, n_together = 12 };
    for (uint8_t start = 0; start < 16u; start++) {
        for (uint8_t first = 0; first < n_commands; first = (uint8_t)(first + n_together)) {
            uint8_t bytes[4 + can_order * n_together] = {start,
                                                         (uint8_t)(start % fuzz_rig_n_parts)};
            for (uint8_t i = 0; i < n_together; i++) {
                const uint8_t order[can_order] = {
                    15, 8, 3, 0, (uint8_t)(first + i), (uint8_t)(i % 3u), 0, 0, (uint8_t)(i * 16u)};
                memcpy(bytes + 4 + i * can_order, order, sizeof order);
            }
            char name[64];
            (void)snprintf(name, sizeof name, "command_%u_%u", (unsigned)start, (unsigned)first);
            put("can", name, bytes, sizeof bytes);
        }
    }
    // A download of 32 bytes: begin, two frames of a block, the end.
    static const uint8_t download[][can_order] = {
        {15, 8, 3, 0, 16, 0, 0, 0, 32},
        {15, 1, 3, 0, 0x10, 36, 0, 0, 0, 0, 1, 2},
        {15, 1, 3, 0, 0x21, 1, 2, 3, 4, 5, 6, 7},
        {15, 1, 3, 0, 0x22, 1, 2, 3, 4, 5, 6, 7},
        {15, 1, 3, 0, 0x23, 1, 2, 3, 4, 5, 6, 7},
        {15, 1, 3, 0, 0x24, 1, 2, 3, 4, 5, 6, 7},
        {15, 1, 3, 0, 0x25, 1, 2, 0, 0, 0, 0, 0},
        {15, 8, 3, 0, 17, 0, 0, 0, 1, 2, 3, 4},
        {15, 8, 3, 0, 8},
    };
    uint8_t bytes[4 + sizeof download] = {0};
    memcpy(bytes + 4, download, sizeof download);
    put("can", "download", bytes, sizeof bytes);
}

static void put_kept(void)
{
    static char text[cam_param_store_most_bytes];
    cam_params_t params = cam_param_defaults();
    put("kept", "defaults", text, cam_param_store_write(text, &params, 7));
    static const char brief[] = "# a comment\nversion = 3\nlead_ns = 5000\nu_stroke_nm = 900000\n";
    char closed[128];
    const int n = snprintf(closed, sizeof closed, "%scrc32 = %lu\n", brief,
                           (unsigned long)cam_crc32(0, brief, sizeof brief - 1u));
    put("kept", "brief", closed, (size_t)n);
    const uint32_t head[] = {
        0x31584243, CAM_BLACKBOX_SIGNALS, 20000, 1, 10, 20, 3, 15, 7, 1, 11, 1, 0, 0};
    uint8_t box[1 + sizeof head + 20 * 9 * 4 + 4] = {'B'};
    memcpy(box + 1, head, sizeof head);
    const uint32_t n_kept = 14 + 20 * 9;
    box[sizeof box - 4] = (uint8_t)n_kept;
    put("kept", "box", box, sizeof box);
    static const uint8_t learned[] = {'L', 0, 1, 0, 0, 0, 3, 100, 0, 0, 0, 20, 7, 0, 0, 0};
    put("kept", "learned", learned, sizeof learned);
}

/// A file of people behind the byte that says which reader takes it.
static void put_text(const char *target, const char *name, char reader, const char *path)
{
    static char text[4096];
    FILE *file = fopen(path, "rb");
    FUZZ_EXPECT(file != NULL, "%s cannot be opened", path);
    text[0] = reader;
    const size_t n = fread(text + 1, 1, sizeof text - 1u, file);
    (void)fclose(file);
    put(target, name, text, n + 1u);
}

static void put_texts(void)
{
    static const char *const machines[] = {"cam", "default", "piezo", "real", "rough"};
    static const char *const words[] = {
        "Iestop@2",     "Icounts@t1.5:-7",
        "Ilate@0.1:50", "N1.5e3",
        "N-.5",         "O--rpm\n2500\n--feed\n0.1\n--inject\nestop@2\nt.camtab",
    };
    static const char *const designs[] = {
        "{\"table_crc32\": @, \"design\": {\"shape\": \"cosine\", \"beta\": 1.0, \"radius_mm\": "
        "{\"breaks_mm\": [0, 10, 20], \"coefficients\": [[0, 0, 0.1, 45], [0, -0.01, 0.1, 46]]}, "
        "\"ovality_mm\": {\"breaks_mm\": [0, 20], \"coefficients\": [[0, 0, 0, 0.2]]}}}",
        "{\"table_crc32\": @, \"design\": {\"shape\": \"double-ellipse\", \"beta\": -0.5}, "
        "\"target\": {\"shape\": \"ellipse\"}}",
    };
    char path[most_path], name[64];
    for (size_t i = 0; i < sizeof machines / sizeof machines[0]; i++) {
        (void)snprintf(path, sizeof path, "%s/%s.toml", MACHINES, machines[i]);
        put_text("settings", machines[i], 'M', path);
    }
    put_text("settings", "linux", 'L', HAL_LINUX "/camturn.toml");
    put_text("settings", "desk", 'L', HAL_LINUX "/desk.toml");
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        (void)snprintf(name, sizeof name, "words_%zu", i);
        put("settings", name, words[i], strlen(words[i]));
    }
    for (size_t i = 0; i < sizeof designs / sizeof designs[0]; i++) {
        (void)snprintf(name, sizeof name, "design_%zu", i);
        put("design", name, designs[i], strlen(designs[i]));
    }
}

/// Bytes of every kind, for targets that take any.
static void put_noise(const char *target, size_t n_bytes)
{
    fixture_random_t random = {1};
    for (uint32_t i = 0; i < 8u; i++) {
        char name[16];
        uint8_t bytes[1000];
        for (size_t j = 0; j < n_bytes; j++) {
            bytes[j] = (uint8_t)fixture_random_u32(&random);
        }
        (void)snprintf(name, sizeof name, "noise_%u", (unsigned)i);
        put(target, name, bytes, n_bytes);
    }
}

/// Learning from 40 turns of the same speed: a rehearsal, then engaging and cutting.
static void put_learning(void)
{
    enum { n_turns = 40, turn_bytes = 18, n_rehearsed = 20, n_engaged = 4 };
    static const uint16_t setup[] = {20, 0,  8,   30000, 10000, 900, 16,   5000, 100,
                                     50, 20, 300, 30,    100,   200, 2000, 500};
    static const uint16_t after[] = {1000, 100, 1000, 40, 40};
    uint8_t bytes[sizeof setup + 1 + sizeof after + n_turns * turn_bytes] = {0};
    memcpy(bytes, setup, sizeof setup);
    memcpy(bytes + sizeof setup + 1, after, sizeof after);
    for (uint8_t order = 1; order <= 4u; order++) {
        for (uint32_t i = 0; i < (uint32_t)n_turns; i++) {
            const bool is_rehearsed = i < (uint32_t)n_rehearsed;
            const bool is_engaged = !is_rehearsed && i < (uint32_t)(n_rehearsed + n_engaged);
            const uint8_t state = is_rehearsed ? 0x80 : is_engaged ? 0x82 : 0x83;
            const uint8_t turn[turn_bytes] = {state, 44, 1, order, 136, 19, 44, 1, 1, 10, 0, 0x10};
            memcpy(bytes + sizeof bytes - (n_turns - i) * turn_bytes, turn, sizeof turn);
        }
        char name[16];
        (void)snprintf(name, sizeof name, "order_%u", (unsigned)order);
        put("learning", name, bytes, sizeof bytes);
    }
}

int main(int argc, char **argv)
{
    FUZZ_EXPECT(argc == 2, "usage: fuzz_seeds FOLDER");
    folder = argv[1];
    (void)mkdir(folder, 0777);
    put_images();
    put_sessions();
    put_machines();
    put_frames();
    put_kept();
    put_texts();
    put_noise("servo", 1000);
    put_noise("feasible", 90);
    put_noise("learning", 1000);
    put_learning();
    return 0;
}
