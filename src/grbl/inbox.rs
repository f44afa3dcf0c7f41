//! Bytes in, lines out.

use heapless::{Deque, Vec};

/// Bytes that wait to be read: what a sender may have under way. A line is one shorter at most.
pub const RECEIVE: usize = 255;

/// A line, without its end.
pub type Line = Vec<u8, RECEIVE>;

/// A line that was too long, or came when there was no room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost;

/// What has been received and not been read. A line ends with a line feed, a carriage return, or both.
///
/// A sender that counts characters never sees it full. If it is, the line under way is lost as a whole and so is all behind it until
/// the lines before have been read: half a line must not become another line.
#[derive(Debug, Default)]
pub struct Inbox {
    bytes: Deque<u8, RECEIVE>,
    /// Whole lines among them.
    lines: usize,
    /// Lines behind them that are lost.
    lost: u32,
    /// Everything is lost until what waits has been read.
    spoilt: bool,
    /// A line that is lost has begun and not ended.
    within: bool,
    /// The last byte was a carriage return: a line feed behind it is of the same end.
    returned: bool,
}

impl Inbox {
    /// Takes a byte.
    pub fn push(&mut self, byte: u8) {
        let returned = core::mem::replace(&mut self.returned, byte == b'\r');
        if byte == b'\n' && returned {
            return;
        }
        let byte = if byte == b'\r' { b'\n' } else { byte };
        if !self.spoilt && self.bytes.push_back(byte).is_ok() {
            self.lines += usize::from(byte == b'\n');
            return;
        }
        if !self.spoilt {
            self.spoilt = true;
            while self.bytes.back().is_some_and(|&last| last != b'\n') {
                self.bytes.pop_back();
            }
        }
        self.within = byte != b'\n';
        self.lost += u32::from(!self.within);
    }

    /// Takes the next line out; `None` if none is whole.
    pub fn take(&mut self, line: &mut Line) -> Option<Result<(), Lost>> {
        if self.lines > 0 {
            line.clear();
            while let Some(byte) = self.bytes.pop_front()
                && byte != b'\n'
            {
                // It has room for all that can wait.
                let _ = line.push(byte);
            }
            self.lines -= 1;
            return Some(Ok(()));
        }
        let is_lost = self.lost > 0;
        self.lost -= u32::from(is_lost);
        self.spoilt &= self.lost > 0 || self.within;
        is_lost.then_some(Err(Lost))
    }

    /// Bytes for which there is room.
    pub fn room(&self) -> usize {
        if self.spoilt { 0 } else { RECEIVE - self.bytes.len() }
    }

    /// Lines that wait, one that has begun among them.
    pub fn waiting(&self) -> usize {
        let begun = self.bytes.back().is_some_and(|&last| last != b'\n');
        self.lines + self.lost as usize + usize::from(begun || self.within)
    }

    /// Drops a line that has begun and not ended.
    pub fn cut(&mut self) {
        while self.bytes.back().is_some_and(|&last| last != b'\n') {
            self.bytes.pop_back();
        }
        (self.within, self.returned) = (false, false);
    }

    /// Drops everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;
    use std::vec::Vec;

    fn lines(inbox: &mut Inbox) -> Vec<Result<String, Lost>> {
        let mut line = Line::new();
        let take = || {
            let taken = inbox.take(&mut line)?;
            Some(taken.map(|()| String::from_utf8_lossy(&line).into_owned()))
        };
        core::iter::from_fn(take).collect()
    }

    fn push(inbox: &mut Inbox, bytes: &[u8]) {
        for &byte in bytes {
            inbox.push(byte);
        }
    }

    #[test]
    fn every_kind_of_end_is_one_end() {
        let mut inbox = Inbox::default();
        push(&mut inbox, b"a\nb\rc\r\n\n\r\nd");
        assert_eq!(lines(&mut inbox), ["a", "b", "c", "", ""].map(|line| Ok(line.into())));
        assert_eq!((inbox.waiting(), inbox.room()), (1, RECEIVE - 1));
        push(&mut inbox, b"\n");
        assert_eq!(lines(&mut inbox), [Ok("d".into())]);
    }

    /// As many answers as lines, and no line of parts of others.
    #[test]
    fn what_finds_no_room_is_lost_by_whole_lines() {
        let mut inbox = Inbox::default();
        push(&mut inbox, b"kept\n");
        push(&mut inbox, &[b'x'; RECEIVE]);
        assert_eq!(inbox.room(), 0);
        push(&mut inbox, b"\nlost too\nhalf");
        let lost = Err(Lost);
        assert_eq!(lines(&mut inbox), [Ok("kept".into()), lost.clone(), lost.clone()]);
        push(&mut inbox, b" and half\nnext\n");
        assert_eq!(lines(&mut inbox), [lost.clone(), lost]);
        push(&mut inbox, b"good\n");
        assert_eq!(lines(&mut inbox), [Ok("good".into())]);
    }

    /// Half a line is none, and what comes next is not glued to it; whole lines stay, and lost ones are told.
    #[test]
    fn a_line_that_is_cut_off_is_dropped() {
        let mut inbox = Inbox::default();
        push(&mut inbox, b"kept\nG1X100.5");
        inbox.cut();
        push(&mut inbox, b"\nnext\n");
        assert_eq!(lines(&mut inbox), ["kept", "", "next"].map(|line| Ok(line.into())));
        push(&mut inbox, &[b'x'; RECEIVE + 1]);
        inbox.cut();
        assert_eq!((lines(&mut inbox), inbox.room()), (Vec::new(), RECEIVE));
        push(&mut inbox, b"a\r");
        inbox.cut();
        push(&mut inbox, b"\nb\n");
        assert_eq!(lines(&mut inbox), ["a", "", "b"].map(|line| Ok(line.into())));
    }

    #[test]
    fn the_longest_line_is_one_shorter_than_the_room() {
        let mut inbox = Inbox::default();
        push(&mut inbox, &[b'y'; RECEIVE - 1]);
        push(&mut inbox, b"\n");
        assert_eq!(lines(&mut inbox), [Ok("y".repeat(RECEIVE - 1))]);
        push(&mut inbox, &[b'y'; RECEIVE]);
        push(&mut inbox, b"\n");
        assert_eq!(lines(&mut inbox), [Err(Lost)]);
        assert_eq!(inbox.room(), RECEIVE);
    }
}
