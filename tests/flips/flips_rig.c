// SPDX-License-Identifier: Apache-2.0
#include "flips_rig.h"
#include "cam_machine.h" // cam_machine_t, for the digest
#include "flips_inner.h"
#include "image_machine.h"
#include "mps2_machine.h"
#include "mps2_semihost.h"
#include <stddef.h> // offsetof
#include <string.h> // memcpy

#define AIRCR (*(volatile uint32_t *)0xE000ED0Cu)
#define NVIC_SET_PENDING (*(volatile uint32_t *)0xE000E200u)
enum { reset_request = 0x05FA0004, ticker_bit = 1u << 8 };

extern uint32_t mps2_data_start[], mps2_bss_end[], mps2_stack_top[];
extern cam_machine_t flips_machine;

static uint32_t data_words(void)
{
    return (uint32_t)(mps2_bss_end - mps2_data_start);
}

static uint32_t *stack_low(void)
{
    return (uint32_t *)((uintptr_t)mps2_stack_top - flips_stack_bytes);
}

/// Where in the cut checkpoints are taken: approach, engaging, three in the cut, disengaging.
static bool is_place(void)
{
    static uint32_t n_in_state;
    static cam_state_t last;
    static const struct {
        cam_state_t state;
        uint32_t after;
    } places[flips_n_checkpoints] = {
        {cam_state_engaging, 40},  {cam_state_engaging, 3500}, {cam_state_cutting, 200},
        {cam_state_cutting, 1503}, {cam_state_cutting, 3006},  {cam_state_disengaging, 150},
    };
    const cam_state_t state = g_cam.motion.state;
    n_in_state = state == last ? n_in_state + 1u : 0u;
    last = state;
    return RIG->n_taken < flips_n_checkpoints && state == places[RIG->n_taken].state &&
           n_in_state == places[RIG->n_taken].after;
}

static void next_run(void);

/// Keep everything; the same place is passed again each time it is restored.
static void take(void)
{
    const uint32_t i = RIG->n_taken;
    if (flips_keep_registers(&RIG->context[i]) == 0u) {
        RIG->clock[i] = flips_time_clock();
        RIG->timer[i] = TICKER.value;
        (void)memcpy(RIG_SNAPSHOT(i), mps2_data_start, data_words() * 4u);
        (void)memcpy(RIG_SNAPSHOT(i) + data_words(), stack_low(), flips_stack_bytes);
        RIG->n_taken++;
        flips_time_restore(RIG->clock[i], RIG->timer[i]); // keeping took longer than a tick
    }
}

/// Runs on the rig's own stack, called by reset.
__attribute__((used)) void flips_restore(void)
{
    const uint32_t i = RIG->strike[RIG->next].checkpoint;
    const uint32_t *from = RIG_SNAPSHOT(i);
    (void)memcpy(mps2_data_start, from, data_words() * 4u);
    (void)memcpy(stack_low(), from + data_words(), flips_stack_bytes);
    flips_time_restore(RIG->clock[i], RIG->timer[i]);
    flips_take_registers(&RIG->context[i]);
}

/// A cheap sum over all that the controller keeps but for the ring of records.
static uint32_t digest(void)
{
    uint32_t sum = 2166136261u;
    const uint32_t *word = (const uint32_t *)(const void *)&g_cam;
    for (uint32_t i = 0; i < offsetof(cam_t, trace) / 4u; i++) {
        sum = (sum ^ word[i]) * 16777619u;
    }
    word = (const uint32_t *)(const void *)&flips_machine;
    for (uint32_t i = 0; i < sizeof flips_machine / 4u; i++) {
        sum = (sum ^ word[i]) * 16777619u;
    }
    return sum;
}

static bool is_same(const flips_tick_t *a, const flips_tick_t *b)
{
    return a->nm[0] == b->nm[0] && a->nm[1] == b->nm[1] && a->nm[2] == b->nm[2] &&
           a->spindle_mrpm == b->spindle_mrpm && a->outputs == b->outputs;
}

void flips_finish(flips_end_t end, uint32_t detail)
{
    STRIKER.control = 0;
    flips_result_t *result = &RIG->result;
    const flips_strike_t *strike = &RIG->strike[RIG->next];
    const flips_tick_t *golden = RIG->golden[strike->checkpoint];
    result->end = end;
    result->detail = detail;
    result->n_ticks = RIG->tick;
    result->idle_tick = RIG->idle_tick;
    result->digest = digest();
    if (strike->kind == flips_nothing && strike->bit == 0u) { // the run to compare with
        (void)memcpy(RIG->golden[strike->checkpoint], RIG->trace, sizeof RIG->trace);
        result->first = 0;
    } else {
        result->first = 0;
        while (result->first < RIG->tick &&
               is_same(&RIG->trace[result->first], &golden[result->first])) {
            result->first++;
        }
    }
    result->n_told = RIG->tick - result->first;
    (void)mps2_file_write(RIG->file, result, sizeof *result);
    (void)mps2_file_write(RIG->file, &RIG->trace[result->first],
                          result->n_told * sizeof(flips_tick_t));
    RIG->next++;
    next_run();
    for (;;) {
    }
}

static void next_run(void)
{
    if (RIG->next == RIG->n_strikes) {
        RIG->magic = 0;
        mps2_exit(0);
    }
    RIG->result = (flips_result_t){.id = RIG->strike[RIG->next].id};
    RIG->tick = 0;
    RIG->idle_count = 0;
    RIG->idle_tick = 0;
    RIG->is_armed = false;
    RIG->is_watching = false;
    RIG->is_running = true;
    RIG->magic = flips_magic;
    __asm volatile("dsb" ::: "memory");
    AIRCR = reset_request;
    __asm volatile("dsb" ::: "memory");
    for (;;) {
    }
}

__attribute__((used)) void flips_caught(uint32_t number)
{
    flips_finish(flips_exception, number);
}

void flips_halted(int status)
{
    (void)status;
    flips_finish(flips_halt, 0);
}

/// The interrupt of the tick is pending as soon as interrupts are on; in it everything is restored.
void flips_begin(void)
{
    if (RIG->magic != flips_magic) {
        RIG->n_taken = 0;
        RIG->is_running = false;
        return;
    }
    flips_set_vectors();
    *(volatile uint32_t *)0xE000E100u = ticker_bit;
    ((volatile uint8_t *)0xE000E400u)[8] = 0x40;
    NVIC_SET_PENDING = ticker_bit;
    for (;;) {
    }
}

void flips_before_isr(void)
{
    if (RIG->is_running && RIG->tick == 0u) {
        RIG->tick = 1;
        __asm volatile("ldr sp, =0x60FF0000\n b flips_restore");
    }
    if (RIG->is_running) {
        flips_arm();
        RIG->trace[RIG->tick].idle = flips_idle.at;
        RIG->trace[RIG->tick].begin = flips_period - TICKER.value;
    }
}

static void trace(void)
{
    flips_tick_t *now = &RIG->trace[RIG->tick];
    for (uint32_t i = 0; i < 3u; i++) {
        now->nm[i] = mps2_machine.out.axis[i].pos_nm;
    }
    now->spindle_mrpm = mps2_machine.out.spindle_mrpm;
    now->outputs = mps2_machine.out.outputs;
    now->faults = g_cam.guard.faults;
    if (flips_idle.count != RIG->idle_count) {
        RIG->idle_count = flips_idle.count;
        RIG->idle_tick = RIG->tick;
    }
}

/// @return whether the run is over: at the horizon, or with a fault when enable has dropped
static bool is_over(void)
{
    const uint32_t outputs = mps2_machine.out.outputs;
    const bool is_faulty = (outputs & hal_out_fault) != 0u;
    const bool is_out = is_faulty && (outputs & hal_out_enable) == 0u;
    return RIG->tick >= flips_most || (RIG->tick >= flips_horizon && (!is_faulty || is_out));
}

static void begin_runs(void)
{
    const int32_t file = mps2_file_open("flips.in", false);
    RIG->n_strikes = 0;
    while (RIG->n_strikes < flips_max_strikes &&
           mps2_file_read(file, &RIG->strike[RIG->n_strikes], sizeof(flips_strike_t))) {
        RIG->n_strikes++;
    }
    RIG->file = mps2_file_open("flips.out", true);
    RIG->next = 0;
    next_run();
}

void flips_after_isr(void)
{
    if (RIG->is_running) {
        RIG->trace[RIG->tick].end = flips_period - TICKER.value;
        if (RIG->is_watching) {
            STRIKER.value = flips_watchdog_ticks * flips_period;
        }
        trace();
        if (is_over()) {
            flips_finish(flips_ran, 0);
        }
        RIG->tick++;
    }
    image_machine_step_isr();
    if (!RIG->is_running && is_place()) {
        take();
        if (!RIG->is_running && RIG->n_taken == flips_n_checkpoints) {
            begin_runs();
        }
    }
}
