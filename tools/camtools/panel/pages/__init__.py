"""The pages of the panel: each module has a function add(context) that registers one."""
