# SPDX-License-Identifier: Apache-2.0
# Builds replay.so in the folder in which make is called.
obj-m += replay.o
include $(shell $(HALCOMPILE) --print-modinc)

replay.c: $(dir $(abspath $(firstword $(MAKEFILE_LIST))))replay.comp
	$(HALCOMPILE) --preprocess -o $@ $<
