// SPDX-License-Identifier: Apache-2.0
#include "sim_firmware.h"
#include "cam_machine.h" // cam_machine_hold

bool sim_firmware_open(sim_firmware_t *f, const char *target, const char *image, common_error_t *e)
{
    *f = (sim_firmware_t){0};
    if (target == NULL) {
        cam_machine_init(&f->machine, &g_cam, hal_tick_hz(), hal_clock_hz());
        return true;
    }
    f->remote = sim_remote_open(target, image, e);
    return f->remote != NULL;
}

void sim_firmware_close(sim_firmware_t *f)
{
    sim_remote_close(f->remote);
    f->remote = NULL;
}

bool sim_firmware_is_lost(const sim_firmware_t *f, common_error_t *e)
{
    if (f->remote == NULL || !f->remote->is_lost) {
        return false;
    }
    *e = f->remote->error;
    return true;
}

int32_t sim_firmware_param(sim_firmware_t *f, cam_param_id_t id)
{
    if (f->remote == NULL) {
        return cam_param_get(&f->machine.params, id);
    }
    (void)sim_remote_call(f->remote, pil_op_get_param, (uint32_t)id, 0);
    return f->remote->answer.value;
}

cam_err_t sim_firmware_set_param(sim_firmware_t *f, cam_param_id_t id, int32_t value)
{
    return f->remote != NULL ? sim_remote_call(f->remote, pil_op_set_param, (uint32_t)id, value)
                             : cam_machine_set_param(&f->machine, id, value);
}

cam_err_t sim_firmware_select_table(sim_firmware_t *f, const void *image, size_t size)
{
    return f->remote != NULL ? sim_remote_select_table(f->remote, image, size)
                             : cam_machine_select_table(&f->machine, image, size);
}

cam_feasibility_t sim_firmware_feasibility(sim_firmware_t *f)
{
    if (f->remote == NULL) {
        return cam_machine_feasibility(&f->machine, 0);
    }
    const cam_err_t err = sim_remote_call(f->remote, pil_op_feasibility, 0, 0);
    return err == cam_ok ? f->remote->answer.feasibility : (cam_feasibility_t){.err = err};
}

cam_err_t sim_firmware_enable(sim_firmware_t *f)
{
    return f->remote != NULL ? sim_remote_call(f->remote, pil_op_enable, 0, 0)
                             : cam_machine_enable(&f->machine);
}

cam_err_t sim_firmware_start(sim_firmware_t *f)
{
    return f->remote != NULL ? sim_remote_call(f->remote, pil_op_start, 0, 0)
                             : cam_machine_start(&f->machine);
}

cam_err_t sim_firmware_stop(sim_firmware_t *f)
{
    return f->remote != NULL ? sim_remote_call(f->remote, pil_op_stop, 0, 0)
                             : cam_machine_stop(&f->machine);
}

cam_err_t sim_firmware_hold(sim_firmware_t *f, bool is_held)
{
    if (f->remote != NULL) {
        return sim_remote_call(f->remote, pil_op_hold, is_held ? 1u : 0u, 0);
    }
    return is_held ? cam_machine_hold(&f->machine) : cam_machine_resume(&f->machine);
}

void sim_firmware_poll(sim_firmware_t *f)
{
    if (f->remote != NULL) {
        (void)sim_remote_call(f->remote, pil_op_poll, 0, 0);
    } else {
        cam_machine_poll(&f->machine);
    }
}

cam_ilc_status_t sim_firmware_learning(sim_firmware_t *f)
{
    if (f->remote == NULL) {
        return cam_machine_learning(&f->machine);
    }
    (void)sim_remote_call(f->remote, pil_op_learning, 0, 0);
    return f->remote->answer.learning;
}

cam_ilc_harmonic_t sim_firmware_harmonic(sim_firmware_t *f, uint32_t k)
{
    if (f->remote == NULL) {
        return cam_ilc_harmonic(&f->machine.ilc, k);
    }
    (void)sim_remote_call(f->remote, pil_op_learning, k, 0);
    return f->remote->answer.harmonic;
}

void sim_firmware_flip(sim_firmware_t *f, uint8_t *image, size_t at)
{
    image[at] ^= 1u;
    if (f->remote != NULL) {
        (void)sim_remote_call(f->remote, pil_op_table_flip, (uint32_t)at, 0);
    }
}
