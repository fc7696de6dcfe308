// SPDX-License-Identifier: Apache-2.0
component mesa_pins "stands in for hostmot2 without the card: the pins that hal/linuxcnc/mesa uses, by the names in its manual";
pin out bit there;
function nothing;
option singleton yes;
option extra_setup yes;
license "GPL";
;;
#define CARD "hm2_5i25.0."
#define N(list) (sizeof(list) / sizeof((list)[0]))

enum { n_stepgens = 3 };

static int make(hal_type_t type, hal_pin_dir_t dir, const char *name)
{
    void **pin = hal_malloc(sizeof *pin);
    return pin == NULL ? -ENOMEM : hal_pin_new(name, type, dir, pin, comp_id);
}

static void rest(void *arg, long period)
{
    (void)arg;
    (void)period;
}

EXTRA_SETUP()
{
    (void)prefix;
    (void)extra_arg;
    static const struct {
        hal_type_t type;
        hal_pin_dir_t dir;
        const char *name;
    } pins[] = {
        {HAL_U32, HAL_IN, CARD "watchdog.timeout_ns"},
        {HAL_BIT, HAL_IO, CARD "watchdog.has_bit"},
        {HAL_BIT, HAL_OUT, CARD "7i77.0.0.input-00"},
        {HAL_BIT, HAL_OUT, CARD "7i77.0.0.input-01"},
        {HAL_BIT, HAL_OUT, CARD "7i77.0.0.input-02"},
        {HAL_BIT, HAL_IN, CARD "7i77.0.0.output-00"},
        {HAL_BIT, HAL_IN, CARD "7i77.0.1.spinena"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout5"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout5-scalemax"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout5-minlim"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout5-maxlim"},
        {HAL_BIT, HAL_IN, CARD "7i77.0.1.analogena"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout0"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout0-scalemax"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout0-minlim"},
        {HAL_FLOAT, HAL_IN, CARD "7i77.0.1.analogout0-maxlim"},
        {HAL_S32, HAL_OUT, CARD "encoder.00.rawcounts"},
        {HAL_S32, HAL_OUT, CARD "encoder.00.count"},
        {HAL_BIT, HAL_IO, CARD "encoder.00.index-enable"},
        {HAL_FLOAT, HAL_OUT, CARD "encoder.00.position"},
        {HAL_FLOAT, HAL_OUT, CARD "encoder.00.velocity"},
        {HAL_FLOAT, HAL_IN, CARD "encoder.00.scale"},
        {HAL_FLOAT, HAL_OUT, CARD "encoder.01.position"},
        {HAL_FLOAT, HAL_OUT, CARD "encoder.01.velocity"},
        {HAL_FLOAT, HAL_IN, CARD "encoder.01.scale"},
    };
    static const struct {
        hal_type_t type;
        hal_pin_dir_t dir;
        const char *name;
    } step_pins[] = {
        {HAL_FLOAT, HAL_IN, "position-scale"}, {HAL_FLOAT, HAL_IN, "position-cmd"},
        {HAL_FLOAT, HAL_OUT, "position-fb"},   {HAL_BIT, HAL_IN, "enable"},
        {HAL_FLOAT, HAL_IN, "maxaccel"},       {HAL_U32, HAL_IN, "steplen"},
        {HAL_U32, HAL_IN, "stepspace"},        {HAL_U32, HAL_IN, "dirsetup"},
        {HAL_U32, HAL_IN, "dirhold"},
    };
    int err = 0;
    for (unsigned i = 0; err == 0 && i < N(pins); i++) {
        err = make(pins[i].type, pins[i].dir, pins[i].name);
    }
    for (unsigned i = 0; err == 0 && i < n_stepgens * N(step_pins); i++) {
        char name[HAL_NAME_LEN + 1];
        rtapi_snprintf(name, sizeof name, CARD "stepgen.%02u.%s", i / (unsigned)N(step_pins),
                       step_pins[i % N(step_pins)].name);
        err = make(step_pins[i % N(step_pins)].type, step_pins[i % N(step_pins)].dir, name);
    }
    static const char *const functions[] = {CARD "read", CARD "write"};
    for (unsigned i = 0; err == 0 && i < N(functions); i++) {
        err = hal_export_funct(functions[i], rest, NULL, 1, 0, comp_id);
    }
    return err;
}

FUNCTION(nothing)
{
    there = 1;
}
