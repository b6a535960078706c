//! The output of a running program: all of it is read, so that the program can go on; the beginning is kept.

use std::{
    io::Read,
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{Receiver, channel},
    },
    thread,
    time::Instant,
};

/// Bytes of a stream that are kept.
pub const KEPT: usize = 1 << 20;

/// A stream that a thread reads to its end.
pub(super) struct Stream {
    kept: Arc<Mutex<Kept>>,
    ended: Receiver<()>,
}

#[derive(Default)]
struct Kept {
    bytes: Vec<u8>,
    left_out: u64,
}

/// Reads a stream on a thread of its own.
pub(super) fn keep(mut stream: impl Read + Send + 'static) -> Stream {
    let kept = Arc::new(Mutex::new(Kept::default()));
    let (sender, ended) = channel();
    let shared = Arc::clone(&kept);
    thread::spawn(move || {
        let mut part = vec![0; 1 << 16];
        while let Ok(count) = stream.read(&mut part)
            && count > 0
        {
            let mut kept = shared.lock().unwrap_or_else(PoisonError::into_inner);
            let fits = count.min(KEPT - kept.bytes.len());
            kept.bytes.extend_from_slice(&part[..fits]);
            kept.left_out += (count - fits) as u64;
        }
        let _ = sender.send(());
    });
    Stream { kept, ended }
}

impl Stream {
    /// What was kept once the stream has ended, or at that time.
    pub(super) fn text(self, at: Instant) -> String {
        let _ = self.ended.recv_timeout(at.saturating_duration_since(Instant::now()));
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let mut text = String::from_utf8_lossy(&kept.bytes).into_owned();
        if kept.left_out > 0 {
            text += &format!("\n… {} more bytes of output", kept.left_out);
        }
        text
    }
}
