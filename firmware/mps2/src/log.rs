//! The log, and what happens when there is nothing left but to say why.

use crate::device::UART;
use core::fmt::{self, Write};
use core::panic::PanicInfo;

/// The log: takes text at once.
pub struct Log;

impl Write for Log {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let [_, _, log, _] = &UART;
        for byte in text.bytes() {
            log.data.write(byte.into());
        }
        Ok(())
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let _ = writeln!(Log, "{info}");
    loop {
        core::hint::spin_loop();
    }
}
