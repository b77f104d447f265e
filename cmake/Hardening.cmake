# What the compiler and the linker do against an attacker who has found a fault: bounds where the size is known, a guarded
# and probed stack, indirect jumps to marked targets only, and no table that can be overwritten after the start.
# docs/decisions/101-hardening.md. Under sanitizers, which watch the same things and more: the
# checks that are left out elsewhere.
include(CheckCXXCompilerFlag)
option(STILLPOINT_HARDENED "Compile and link with the protections of cmake/Hardening.cmake" ON)

set(STILLPOINT_HARDENING)
if(STILLPOINT_HARDENED AND NOT STILLPOINT_SANITIZE)
  foreach(flag -fstack-protector-strong -fstack-clash-protection -fcf-protection=full -mbranch-protection=standard)
    string(MAKE_C_IDENTIFIER "STILLPOINT_HAS${flag}" known)
    check_cxx_compiler_flag(${flag} ${known})
    if(${known})
      list(APPEND STILLPOINT_HARDENING ${flag})
    endif()
  endforeach()
  # Needs an optimising build; the system may have set another level.
  list(APPEND STILLPOINT_HARDENING $<$<CONFIG:Release>:-U_FORTIFY_SOURCE> $<$<CONFIG:Release>:-D_FORTIFY_SOURCE=3>)
  add_link_options(LINKER:-z,relro LINKER:-z,now LINKER:-z,noexecstack)
elseif(STILLPOINT_SANITIZE MATCHES undefined)
  set(STILLPOINT_HARDENING -fsanitize=null,alignment)
endif()

# What reads bytes that others have written: the network, and the program around it. The numbers in between see no byte of
# a stranger.
function(stillpoint_harden)
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE ${STILLPOINT_HARDENING})
    get_target_property(kind ${target} PRECOMPILE_HEADERS_REUSE_FROM)
    if(kind)
      set_target_properties(${target} PROPERTIES PRECOMPILE_HEADERS_REUSE_FROM ${kind}_hardened)
    endif()
  endforeach()
endfunction()
