# The library for C, in somebody's own Makefile (docs/c.md):
#
#   SPLINEWAY_CONFIG = splineway_config.h        # sizes and features
#   include splineway/src/c/splineway.mk         # behind CC and CFLAGS
#   CFLAGS += $(SPLINEWAY_CFLAGS)
#   firmware.elf: $(OBJECTS) $(SPLINEWAY_LIB)    # and both on the linker's command line
#
# Needs GNU make, cargo, and the Rust target that CC compiles for: `rustup target add thumbv7em-none-eabihf`.

splineway_goal := $(.DEFAULT_GOAL)
SPLINEWAY_ROOT := $(abspath $(dir $(lastword $(MAKEFILE_LIST)))../..)
# cargo, or what is called like it.
SPLINEWAY_CARGO ?= cargo
# Where cargo builds.
SPLINEWAY_CARGO_DIR ?= $(CURDIR)/splineway-cargo
# Flags that say what CC compiles for.
SPLINEWAY_CPU ?= $(filter -m% --target=%,$(CC) $(CPPFLAGS) $(CFLAGS))

# The header is the only place where anything is chosen: where there is none, one that chooses nothing stands for it.
ifeq ($(SPLINEWAY_CONFIG),)
SPLINEWAY_CFLAGS := -DSPLINEWAY_CONFIG_FILE='<stdint.h>' -I$(SPLINEWAY_ROOT)/src/c
else
ifeq ($(wildcard $(SPLINEWAY_CONFIG)),)
$(error SPLINEWAY_CONFIG: there is no $(SPLINEWAY_CONFIG))
endif
SPLINEWAY_CFLAGS := -DSPLINEWAY_CONFIG_FILE='"$(abspath $(SPLINEWAY_CONFIG))"' -I$(SPLINEWAY_ROOT)/src/c
endif

# What the compiler knows of its target, and what the header chooses, as it sees both: words NAME=VALUE.
splineway_macros := $(shell $(CC) $(SPLINEWAY_CPU) -E -dM -x c $(or $(SPLINEWAY_CONFIG),/dev/null) | tr -d '\r' | \
  sed -n 's/^.define \(SPLINEWAY_[A-Z]*\|__ARM_[A-Z0-9_]*\|__STDC__\) /\1=/p' | tr -d ' ')
ifeq ($(filter __STDC__=1,$(splineway_macros)),)
$(error $(CC) $(SPLINEWAY_CPU) cannot read $(SPLINEWAY_CONFIG))
endif
splineway_wrong := $(filter-out %=plain,$(shell echo '$(filter SPLINEWAY_AXES=% SPLINEWAY_BLOCKS=% SPLINEWAY_NODES=% SPLINEWAY_HISTORY=% \
  SPLINEWAY_OUTPUTS=% SPLINEWAY_KINEMATICS=% SPLINEWAY_SHAPING=%,$(splineway_macros))' | sed 's/=[0-9][0-9]*\( \|$$\)/=plain\1/g'))
ifneq ($(splineway_wrong),)
$(error $(SPLINEWAY_CONFIG): $(splineway_wrong) must be a plain number)
endif
splineway_chosen = $(or $(patsubst SPLINEWAY_$(1)=%,%,$(filter SPLINEWAY_$(1)=%,$(splineway_macros))),$(2))
splineway_environment := SPLINEWAY_AXES=$(call splineway_chosen,AXES,3) SPLINEWAY_BLOCKS=$(call splineway_chosen,BLOCKS,16) \
  SPLINEWAY_NODES=$(call splineway_chosen,NODES,64) SPLINEWAY_HISTORY=$(call splineway_chosen,HISTORY,64)
splineway_feature = $(if $(filter-out 0,$(call splineway_chosen,$(1),0)),$(2))
splineway_features := c-lib $(call splineway_feature,OUTPUTS,outputs) \
  $(call splineway_feature,KINEMATICS,kinematics) $(call splineway_feature,SHAPING,shaping)

# Rust's names of the Cortex-M that have compare-and-swap; a host is what cargo builds for by itself.
splineway_has = $(filter __ARM_ARCH_$(1)__=%,$(splineway_macros))
splineway_core := $(or $(if $(call splineway_has,7EM),thumbv7em),$(if $(call splineway_has,7M),thumbv7m),\
  $(if $(call splineway_has,8M_MAIN)$(call splineway_has,8_1M_MAIN),thumbv8m.main),$(if $(call splineway_has,8M_BASE),thumbv8m.base))
ifneq ($(splineway_core),)
SPLINEWAY_TARGET ?= $(strip $(splineway_core))-none-$(if $(filter __ARM_PCS_VFP=%,$(splineway_macros)),eabihf,eabi)
else ifneq ($(filter __ARM_ARCH_PROFILE=% __ARM_ARCH_4T__=%,$(splineway_macros)),)
ifeq ($(SPLINEWAY_TARGET),)
$(error No target is known for what $(CC) $(SPLINEWAY_CPU) compiles for: are CPU and float ABI in CFLAGS? SPLINEWAY_TARGET names \
  it: a processor with compare-and-swap (a Cortex-M0 has none))
endif
endif
splineway_arguments := rustc --locked --profile firmware --package splineway --lib --features "$(strip $(splineway_features))" \
  --crate-type staticlib --target-dir $(SPLINEWAY_CARGO_DIR) $(if $(SPLINEWAY_TARGET),--target $(SPLINEWAY_TARGET))
SPLINEWAY_LIB := $(SPLINEWAY_CARGO_DIR)/$(if $(SPLINEWAY_TARGET),$(SPLINEWAY_TARGET)/)firmware/libsplineway.a

# cargo knows what is up to date; it is asked every time, and what depends on the library is made anew if it has changed.
$(SPLINEWAY_LIB): splineway-cargo
	@:
.PHONY: splineway-cargo
splineway-cargo:
	+cd $(SPLINEWAY_ROOT) && $(splineway_environment) $(SPLINEWAY_CARGO) $(splineway_arguments)

# Not what `make` makes.
.DEFAULT_GOAL := $(splineway_goal)
