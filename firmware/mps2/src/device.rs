//! The chip: interrupts and registers that the image uses, of ARM's Application Note AN386 and the Cortex-M System Design Kit.

use cortex_m::interrupt::InterruptNumber;
// Its vector table is continued here.
use cortex_m_rt as _;

/// Bits of a priority.
pub const NVIC_PRIO_BITS: u8 = 3;

/// Interrupts, by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
#[allow(non_camel_case_types)]
pub enum Interrupt {
    UART0_RX = 0,
    UART0_TX = 1,
    UART1_RX = 2,
    UART1_TX = 3,
    UART2_RX = 4,
    UART2_TX = 5,
    TIMER0 = 8,
    TIMER1 = 9,
    DUALTIMER = 10,
    SPI = 11,
    UART3_RX = 18,
    UART3_TX = 19,
}

// The framework asks for both names.
pub use Interrupt as interrupt;

// SAFETY: the numbers are those of the chip, each once.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

unsafe extern "C" {
    fn UART0_RX();
    fn UART0_TX();
    fn UART1_RX();
    fn UART1_TX();
    fn UART2_RX();
    fn UART2_TX();
    fn TIMER0();
    fn TIMER1();
    fn DUALTIMER();
    fn SPI();
    fn UART3_RX();
    fn UART3_TX();
}

/// A word of the vector table.
#[derive(Clone, Copy)]
pub union Vector {
    handler: unsafe extern "C" fn(),
    none: u32,
}

/// Interrupts that the chip has.
const INTERRUPTS: usize = 32;

#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [Vector; INTERRUPTS] = {
    let mut table = [Vector { none: 0 }; INTERRUPTS];
    table[Interrupt::UART0_RX as usize] = Vector { handler: UART0_RX };
    table[Interrupt::UART0_TX as usize] = Vector { handler: UART0_TX };
    table[Interrupt::UART1_RX as usize] = Vector { handler: UART1_RX };
    table[Interrupt::UART1_TX as usize] = Vector { handler: UART1_TX };
    table[Interrupt::UART2_RX as usize] = Vector { handler: UART2_RX };
    table[Interrupt::UART2_TX as usize] = Vector { handler: UART2_TX };
    table[Interrupt::TIMER0 as usize] = Vector { handler: TIMER0 };
    table[Interrupt::TIMER1 as usize] = Vector { handler: TIMER1 };
    table[Interrupt::DUALTIMER as usize] = Vector { handler: DUALTIMER };
    table[Interrupt::SPI as usize] = Vector { handler: SPI };
    table[Interrupt::UART3_RX as usize] = Vector { handler: UART3_RX };
    table[Interrupt::UART3_TX as usize] = Vector { handler: UART3_TX };
    table
};

/// A register of 32 bits.
#[derive(Clone, Copy)]
pub struct Register(usize);

impl Register {
    /// The one at an address of this chip's map.
    const fn at(address: usize) -> Self {
        Self(address)
    }

    /// Reads it.
    #[inline]
    pub fn read(self) -> u32 {
        // SAFETY: a register of a peripheral, by `at`; reading one harms no memory.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    /// Writes it.
    #[inline]
    pub fn write(self, value: u32) {
        // SAFETY: as above; no peripheral used here writes to memory.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}

/// A serial port (CMSDK APB UART).
pub struct Uart {
    /// A byte, either way.
    pub data: Register,
    /// Bit 0: transmitter full; bit 1: receiver full; bit 2: a byte was written while it was full.
    pub state: Register,
    /// Bits 0 and 1: transmitter and receiver on; bits 2 and 3: their interrupts.
    pub control: Register,
    /// Interrupts; writing ones clears them.
    pub pending: Register,
    /// Clock cycles per bit.
    pub divider: Register,
}

impl Uart {
    const fn at(base: usize) -> Self {
        Self {
            data: Register::at(base),
            state: Register::at(base + 4),
            control: Register::at(base + 8),
            pending: Register::at(base + 12),
            divider: Register::at(base + 16),
        }
    }
}

/// A timer that counts down (CMSDK APB timer).
pub struct Timer {
    /// Bit 0: on; bit 3: interrupt.
    pub control: Register,
    /// What it has come to.
    pub value: Register,
    /// What it begins with, again and again.
    pub reload: Register,
    /// Interrupt; writing 1 clears it.
    pub pending: Register,
}

impl Timer {
    const fn at(base: usize) -> Self {
        Self {
            control: Register::at(base),
            value: Register::at(base + 4),
            reload: Register::at(base + 8),
            pending: Register::at(base + 12),
        }
    }
}

/// Half of the dual timer (CMSDK APB dual timer).
pub struct Half {
    /// What it begins with; writing it begins.
    pub load: Register,
    /// Bit 0: once; bit 1: 32 bits; bit 5: interrupt; bit 6: begins with `load`; bit 7: on.
    pub control: Register,
    /// Writing clears the interrupt.
    pub clear: Register,
    /// Bit 0: its interrupt is pending.
    pub pending: Register,
}

impl Half {
    const fn at(base: usize) -> Self {
        Self {
            load: Register::at(base),
            control: Register::at(base + 8),
            clear: Register::at(base + 12),
            pending: Register::at(base + 20),
        }
    }
}

/// The watchdog (CMSDK APB watchdog): the second time that it comes to zero it resets the chip.
pub struct Watchdog {
    /// What it begins with; writing it begins.
    pub load: Register,
    /// Bit 0: counts; bit 1: resets.
    pub control: Register,
    /// Writing it begins again.
    pub clear: Register,
}

/// Frequency of the peripherals' clock, Hz.
pub const CLOCK_HZ: u32 = 25_000_000;

/// Ports that QEMU calls `serial0` to `serial3`.
pub const UART: [Uart; 4] =
    [Uart::at(0x4000_4000), Uart::at(0x4000_5000), Uart::at(0x4000_6000), Uart::at(0x4000_7000)];
/// Timers 0 and 1.
pub const TIMER: [Timer; 2] = [Timer::at(0x4000_0000), Timer::at(0x4000_1000)];
/// Both halves of the dual timer, which share an interrupt.
pub const DUAL: [Half; 2] = [Half::at(0x4000_2000), Half::at(0x4000_2020)];
/// The watchdog.
pub const WATCHDOG: Watchdog = Watchdog {
    load: Register::at(0x4000_8000),
    control: Register::at(0x4000_8008),
    clear: Register::at(0x4000_800C),
};
