// SPDX-License-Identifier: Apache-2.0
/// stm_selftest: a report on the board over the serial line, for boards that nobody here has.
///
/// The letter t from the terminal starts it, while the drives are disabled. Each line of the report
/// names a part, `ok` or `FAILED`, and what was measured. It ends with a reset by the independent
/// watchdog, which is its last check.
#ifndef STM_SELFTEST_H
#define STM_SELFTEST_H

/// Run the self-test if the terminal has asked for it. While the drives are enabled or flash is
/// being written, one line refuses it. Context: slow side, at every wake-up of the main loop.
/// Does not return from a self-test: half a second of report, then the reset.
void stm_selftest_poll(void);

#endif
