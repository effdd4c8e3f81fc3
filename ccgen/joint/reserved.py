"""Names that others have taken: words that a joint's files, types, functions or targets would meet.

A joint NAME brings NAME.h, types and functions NAME_..., macros in capitals, a CMake target and
package, a library of Arduino and PlatformIO, a component of ESP-IDF and a module of Zephyr. Every
list says what of these would be met; names are compared without regard to capitals where files or
packages meet, because some file systems have none.
"""


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


KEYWORDS = _words(
    """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t
    char8_t class co_await co_return co_yield compl concept const const_cast consteval constexpr
    constinit continue contract_assert decltype default delete do double dynamic_cast else enum
    explicit export extern false final float for fortran friend goto if import inline int linux long
    module mutable namespace new noexcept not not_eq nullptr operator or or_eq override private
    protected public register reinterpret_cast requires restrict return short signed sizeof static
    static_assert static_cast std struct switch template this thread_local throw true try typedef
    typeid typename typeof typeof_unqual union unix unsigned using virtual void volatile wchar_t
    while xor xor_eq
    """
)
"""Keywords of C99 to C23 and of C++14 to C++26, and words that compilers define or reserve."""

TYPES = _words(
    """
    active_reg aio blkcnt blkcnt64 blksize caddr can_err_mask canid cc char16 char32 char8 clock
    clock_div clockid cnd comparison_fn cookie_io_functions cookie_read_function
    cookie_seek_function cpu_set daddr dev div epoll_data error eventfd femode fenv fexcept fpos
    fpos64 fpregset fsblkcnt fsblkcnt64 fsfilcnt fsfilcnt64 fsid gid glob glob64 greg gregset iconv
    id idtype imaxdiv in_addr in_port inet6_opt inet6_option inet6_rth ino ino64 int16 int32 int64
    int8 int_farptr int_fast16 int_fast32 int_fast64 int_fast8 int_least16 int_least32 int_least64
    int_least8 intmax intptr key ldiv lldiv lmid loff max_align mbstate mcontext mode mqd msglen
    msgqnum mtx name nfds nlink off off64 pgn physadr pid priority ptrdiff quad re_dfa reg_errcode
    reg_syntax regex regmatch regoff rlim rlim64 rsize s_reg sa_family sbintime sem shmatt sig
    sig_atomic sigevent sighandler siginfo sigset sigval sin size sockaddr socklen speed ssize stack
    suseconds tcflag thrd thrd_start time timer tss tss_dtor u_int16 u_int32 u_int64 u_int8 u_quad
    u_register ucontext uid uint16 uint32 uint64 uint8 uint_farptr uint_fast16 uint_fast32
    uint_fast64 uint_fast8 uint_least16 uint_least32 uint_least64 uint_least8 uintmax uintptr
    useconds wchar wctrans wctype wint wordexp
    """
)
"""Names whose `NAME_t` is a type of C, of POSIX, of Linux or of a small C library."""

CXX_TYPES = _words(
    """
    add_const add_cv add_lvalue_reference add_pointer add_rvalue_reference add_volatile adopt_lock
    align_val aligned_storage aligned_union allocator_arg atomic borrowed_iterator borrowed_subrange
    common_reference common_type conditional const_mem_fun const_mem_fun1 const_mem_fun1_ref
    const_mem_fun_ref countl countr decay default_sentinel defer_lock destroying_delete enable_if
    from_range from_time in_place in_place_index in_place_type indirect_result invoke_result
    is_standard iter_difference iter_reference iter_value iterator local make_signed make_unsigned
    mem_fun mem_fun1 mem_fun1_ref mem_fun_ref nostopstate nothrow nullopt piecewise_construct
    range_difference range_reference range_size range_value remove_all_extents remove_const
    remove_cv remove_cvref remove_extent remove_pointer remove_reference remove_volatile result_of
    round_toward sentinel strided_slice tempering to_time try_to_lock tuple_element type_identity
    underlying_type unexpect unreachable_sentinel unwrap_ref_decay unwrap_reference value
    variant_alternative
    """
)
"""Names whose `NAME_t` stands in namespace std of C++11 to C++23."""

HEADERS = _words(
    """
    acc_prof aio alias aliases alloca ar argp argz arm_acle arm_bf16 arm_cde arm_cmse arm_fp16
    arm_mve arm_mve_types arm_neon assert backtrace byteswap cet complex cpio cpuid crypt ctype
    devctl dirent dlfcn elf endian envlock envz err errno error execinfo fastmath fcntl features
    fenv float fmtmsg fnmatch fpu_control fstab fts ftw gconv gcov getopt glob gnu_versions grp
    gshadow iconv ieee754 ieeefp ifaddrs intrin inttypes iso646 langinfo lastlog libgen libintl
    limits link locale malloc math mcheck memory mm3dnow mm_malloc mntent monetary mqueue ndbm netdb
    newlib nl_types nss obstack omp openacc paths picolibc picotls poll printf proc_service pthread
    pty pwd quadmath quadmath_weak re_comp reent regdef regex regexp resolv sched search semaphore
    semihost setjmp sgtty shadow signal spawn stab stdalign stdarg stdatomic stdbit stdbool
    stdckdint stddef stdfix stdint stdio stdio_ext stdlib stdnoreturn string strings syscall
    sysexits syslimits syslog tar termio termios tgmath thread_db threads time ttyent uchar ucontext
    ulimit unctrl unistd unwind utime utmp utmpx values varargs veclib wait wchar wctype windows
    winsock winsock2 wordexp
    """
)
"""Names whose `NAME.h`, on the include path, would hide a header of the C library or compiler."""

FOLDER = _words(
    """
    all angles app avr avr_cycle avr_irq axis16 axis32 bare_metal batch block board
    board_atmega1284p board_f4 board_g4 board_microbit board_mps2 board_virt build bxcan
    calibration capture check check16 check32 clean command command_inline core core_vectors
    cortex_m crc e2e e2e_inline elf_firmware error estimator16 estimator32 factors16 firmware
    flash frame github gitlab h health health_inline help host install integer kconfig kernel16
    kernel16_thumb1 kernel32 layout layout_inline libjoint license line link load look main
    manifest mcp2515 model node node_inline options package platformio port ports posix prj
    product ram readme record residuals ring riscv32 riscv_virt sdkconfig selftest semihosting
    sending sending_inline sensors16 sensors32 serving16 serving32 shared simavr_uart slcan snapshot
    snapshot_inline socketcan startup tendons test tip two_joints u v vector version virt watch word
    zephyr zero
    """
)
"""Names of files, types and build targets that the exported folder or an example has itself."""

CMAKE = _words(
    """
    alias all all_build archive clean continuous debug default_target depend edit_cache experimental
    export false file general help imported install install_local install_strip interface languages
    library list_install_components n nightly nightlymemorycheck no none object off on optimized
    package package_source preinstall private project public rebuild_cache run_tests runtime shared
    static test true unknown version y yes zero_check
    """
)
"""Targets that CMake makes itself, with any of its generators, and words of its commands."""

CMAKE_PACKAGES = _words(
    """
    alsa armadillo aspell avifile backtrace bison blas boost bullet bzip2 cable coin3d cuda
    cudatoolkit cups curl curses cvs cxxtest cygwin dart dcmtk devil doxygen envmodules expat flex
    fltk fltk2 fontconfig freetype gccxml gdal gettext gif git glew glu glut gnuplot gnutls gsl
    gtest gtk gtk2 hdf5 hg hspell htmlhelp ice iconv icotool icu imagemagick intl itk jasper java
    jni jpeg kde3 kde4 lapack latex libarchive libinput liblzma libxml2 libxslt lttngust lua lua50
    lua51 matlab mfc motif mpeg mpeg2 mpi msys odbc openacc openal opencl opengl openmp
    openscenegraph opensp openssl openthreads osg osg_functions osganimation osgdb osgfx osgga
    osgintrospection osgmanipulator osgparticle osgpresentation osgproducer osgqt osgshadow osgsim
    osgterrain osgtext osgutil osgviewer osgvolume osgwidget packagehandlestandardargs
    packagemessage patch perl perllibs php4 physfs pike pkgconfig png postgresql producer protobuf
    python python2 python3 pythoninterp pythonlibs qt qt3 qt4 quicktime rti ruby sdl sdl_gfx
    sdl_image sdl_mixer sdl_net sdl_sound sdl_ttf selfpackers sqlite3 squish subversion swig tcl
    tclsh tclstub threads tiff unixcommands vtk vulkan wget wish wxwidgets wxwindows x11 xalanc
    xctest xercesc xmlrpc zlib
    """
)
"""Packages that `find_package` of CMake looks for in its own way."""

FRAMEWORKS = _words(
    """
    app_trace app_update avr_cpunames avrinterruptnames binary boot bootloader bootloader_support bt
    canopennode caterina client cmock cmsis command console cxx descriptors device devicetree driver
    edtt eeprom efuse espcoredump esptool_py ethernet event_groups fatfs firmata hal hardwareserial
    hardwareserial_private heap hid http_parser ieee802154 init ipaddress json kernel keyboard leds
    libmetal lightweightringbuff linker liquidcrystal list littlefs log loramac_node lvgl lwip
    mbedtls mcuboot message_buffer mouse mqtt nanopb nvs_flash open_amp openthread partition_table
    perfmon pin_defs pins_arduino pluggableusb portable portmacro print printable projdefs protocomm
    pthread queue riscv rt sd sdmmc segger semphr server servo settings soc sof softwareserial spi
    spi_flash spiffs stepper stk500 stream stream_buffer task tcp_transport tft timers tinycrypt
    tone toolchain twi udp ulp unity usb usbapi usbcore usbdesc vfs wcharacter wear_levelling wifi
    wifi_provisioning wire wiring wiring_private wpa_supplicant wprogram wstring xtensa zcbor
    """
)
"""Headers and libraries of Arduino, components of ESP-IDF, headers of FreeRTOS, of Zephyr."""

DRIVERS = _words(
    """
    adc aes alarm audio basetype buffer bus button cache can channel chip clock clocks config
    counter cpu crc crypto ctrl current dac data datetime device display dma err eth event events
    fault fdcan fifo filter flash gpio gpio_num gptimer gpu hash i2c i2s i3c int interp interrupt
    interrupts intr irq lcd led ledc lin lldesc lock logger mcpwm mem mmc mmu mpu msg mutex net
    network nvic nvs op out packet pcnt period phy pin pins pio pll pmu pool power publish pwm
    pwrctl qspi random rcc receiver reset ringbuf rmt rng rtc rtos runtime rx s16 s32 s8 scan
    scheduler sdio sensor sensors serial sha256 shell sleep spinlock sync sys syscfg system systick
    systimer taskhandle tasks tick ticks ticktype tim timebase transfer trng twai tx u16 u32 u64 u8
    uart update usart usb_host usbd usbh watchdog wdt work xfer
    """
)
"""Names whose `NAME_init`, `NAME_t` or `NAME.h` chips' vendors and their tools give to drivers."""

LIBRARIES = _words(
    """
    atomic c c_nano dl g gcc gcov gomp itm m nosys pthread rdimon resolv rt semihost ssp stdc supc
    unwind util
    """
)
"""Names whose `libNAME.a` a linker would take for the compiler's or the C library's."""

DEVICES = _words(
    "aux con nul prn " + " ".join(f"com{i} lpt{i}" for i in range(10)) + " conin conout clock"
)
"""Names that no file may have on Windows, whatever its ending."""

PREFIXES = {
    "arduino": "Arduino",
    "atomic_": "C's atomic types",
    "bt_": "Zephyr and ESP-IDF",
    "cmake": "CMake",
    "cmsis": "CMSIS",
    "continuous": "CMake's targets",
    "core_c": "CMSIS",
    "esp_": "ESP-IDF",
    "experimental": "CMake's targets",
    "freertos": "FreeRTOS",
    "hal_": "chips' drivers",
    "idf_": "ESP-IDF",
    "k_": "Zephyr",
    "lwip": "lwIP",
    "mbedtls": "Mbed TLS",
    "net_": "Zephyr",
    "nightly": "CMake's targets",
    "nrf": "chips' drivers",
    "nvs_": "ESP-IDF",
    "pico_": "chips' drivers",
    "posix_": "POSIX",
    "spi_": "chips' drivers",
    "i2c_": "chips' drivers",
    "stm32": "chips' drivers",
    "sys_": "Zephyr",
    "twai_": "ESP-IDF",
    "uart_": "chips' drivers",
    "usb_": "chips' drivers",
    "zephyr": "Zephyr",
}
"""Beginnings that others keep to themselves, and whose they are."""
