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
        {HAL_FLOAT, HAL_IN, CARD "stepgen.00.position-scale"},
        {HAL_FLOAT, HAL_IN, CARD "stepgen.00.position-cmd"},
        {HAL_FLOAT, HAL_OUT, CARD "stepgen.00.position-fb"},
        {HAL_BIT, HAL_IN, CARD "stepgen.00.enable"},
        {HAL_FLOAT, HAL_IN, CARD "stepgen.01.position-scale"},
        {HAL_FLOAT, HAL_IN, CARD "stepgen.01.position-cmd"},
        {HAL_FLOAT, HAL_OUT, CARD "stepgen.01.position-fb"},
        {HAL_BIT, HAL_IN, CARD "stepgen.01.enable"},
    };
    int err = 0;
    for (unsigned i = 0; err == 0 && i < N(pins); i++) {
        err = make(pins[i].type, pins[i].dir, pins[i].name);
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
