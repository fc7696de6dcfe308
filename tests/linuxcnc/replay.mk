# SPDX-License-Identifier: Apache-2.0
# Builds the components of the tests in the folder in which make is called.
obj-m += replay.o mesa_pins.o
include $(shell $(HALCOMPILE) --print-modinc)

%.c: $(dir $(abspath $(firstword $(MAKEFILE_LIST))))%.comp
	$(HALCOMPILE) --preprocess -o $@ $<
