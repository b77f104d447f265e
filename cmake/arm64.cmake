# Debian's cross toolchain for 64-bit ARM; tests run under qemu-user.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
# The libc is that of libc6:arm64, as the libraries are: with the loader of the cross toolchain pthread_create never returns.
set(CMAKE_CROSSCOMPILING_EMULATOR "qemu-aarch64;-L;/")
