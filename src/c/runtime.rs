//! What a library that is linked into a C program must bring along.

/// There is nothing to unwind to, and nothing in the core that could panic: the proof image shows it.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}

/// Hosts come with a compiler runtime that is built for unwinding and asks for this by name. Nothing
/// unwinds here, so nothing calls it.
#[cfg(not(target_os = "none"))]
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}
