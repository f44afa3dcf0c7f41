//! Proof by the linker that no panic can be reached.
//!
//! The images `proof` (the core) and `proof-all` (what lies around it; feature `all`) call everything a
//! controller calls, and their panic handler, which is here, needs a function that does not exist: they link
//! only if no panic can be reached. What a new public function of the core does has to be called there.
//! Nothing here drives a machine.
#![no_std]
// A name for the linker.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod handler {
    use core::panic::PanicInfo;

    unsafe extern "C" {
        /// Defined nowhere.
        fn a_panic_can_be_reached() -> !;
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        // SAFETY: never linked, so never called.
        unsafe { a_panic_can_be_reached() }
    }
}
