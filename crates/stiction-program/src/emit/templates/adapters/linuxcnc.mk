
# Component of LinuxCNC; `halcompile --install @NAME@_hal.comp` installs it.
linuxcnc: @NAME@_hal.comp
	halcompile --compile @NAME@_hal.comp

.PHONY: linuxcnc
