//! The connection to the page: a server on a local port. The page posts the result of a job and gets the next job in answer.
//!
//! Between jobs the page's request stays unanswered. A second thread of the page reports every second that it is alive, which
//! distinguishes a dead page from one that draws for a long time.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::path::Path;
use std::time::{Duration, Instant};

use diffraction_shaders::error::{Error, Result};
use serde_json::Value;

use super::chromium::Chromium;
use super::failure::failure;
use super::server::{HttpRequest, Method, Server, StatusCode};

/// Maximum size of a message, in bytes. A band of a picture has about ten million.
const MAX_BYTES: usize = 1 << 30;

/// The files of the page: name, content type, text.
const FILES: [(&str, &str, &str); 5] = [
    ("", "text/html; charset=utf-8", include_str!("page/page.html")),
    ("page.js", "text/javascript; charset=utf-8", include_str!("page/page.js")),
    ("alive.js", "text/javascript; charset=utf-8", include_str!("page/alive.js")),
    ("webgpu.js", "text/javascript; charset=utf-8", include_str!("page/webgpu.js")),
    ("webgl2.js", "text/javascript; charset=utf-8", include_str!("page/webgl2.js")),
];

/// Maximum time until the page sends its first message; loaded machines are slow.
const START: Duration = Duration::from_secs(90);
/// Maximum time between messages of the page, which sends one every second.
const SILENCE: Duration = Duration::from_secs(45);
/// Maximum time of a job. A band of rows on a software driver takes seconds.
const JOB: Duration = Duration::from_secs(600);
/// Interval between checks whether the program still runs.
const TICK: Duration = Duration::from_millis(100);

/// A browser with our page open.
pub(super) struct Link {
    // declared first, so dropped first: the page must not lose its server and close by itself
    chromium: Chromium,
    server: Server,
    /// First part of every address, a secret from other users of this machine.
    root: String,
    /// The page's request for its next job.
    waiting: Option<HttpRequest>,
    /// Why no further message can come.
    broken: Option<String>,
}

/// A message from the page.
pub(super) struct Message {
    /// A JSON object.
    pub(super) head: Value,
    /// The bytes that follow it.
    pub(super) payload: Vec<u8>,
}

impl Link {
    /// Starts the browser and waits for the page's first message.
    pub(super) fn start(program: Option<&Path>, flags: &[&str]) -> Result<(Link, Message)> {
        let server = Server::open(0, MAX_BYTES)
            .map_err(|e| failure("no local port can be opened").source(e))?;
        let random = || RandomState::new().build_hasher().finish();
        let root = format!("/{:016x}{:016x}/", random(), random());
        let address = format!("http://{}{root}", server.address());
        let chromium = Chromium::start(program, flags, &address)?;
        let mut link = Link { chromium, server, root, waiting: None, broken: None };
        let first = link.receive(START, START)?;
        Ok((link, first))
    }

    /// Sends a job and waits for its result.
    pub(super) fn call(&mut self, head: &Value, payload: &[&[u8]]) -> Result<Message> {
        if let Some(cause) = &self.broken {
            return Err(failure(cause));
        }
        let Some(request) = self.waiting.take() else {
            return Err(self.fail(failure("its page does not answer")));
        };
        request.send("application/octet-stream", pack(head, payload));
        self.receive(SILENCE, JOB)
    }

    /// Id of the browser's first process.
    pub(super) fn id(&self) -> u32 {
        self.chromium.id()
    }

    /// The folder with the browser's profile.
    pub(super) fn profile(&self) -> &Path {
        self.chromium.profile()
    }

    /// Answers requests until the page posts a message.
    fn receive(&mut self, silence: Duration, limit: Duration) -> Result<Message> {
        let begun = Instant::now();
        let mut heard = begun;
        loop {
            match self.server.next(TICK) {
                Ok(Some(request)) => {
                    heard = Instant::now();
                    match self.answer(request) {
                        Ok(Some(message)) => return Ok(message),
                        Ok(None) => {}
                        Err(e) => return Err(self.fail(e)),
                    }
                }
                Ok(None) => {}
                Err(e) => {
                    return Err(self.fail(failure("the local port cannot take requests").source(e)));
                }
            }
            if let Some(e) = self.chromium.ended() {
                return Err(self.fail(e));
            }
            let late = [(heard, silence, "its page was silent"), (begun, limit, "a job took")];
            if let Some((_, limit, what)) =
                late.iter().find(|(since, limit, _)| since.elapsed() > *limit)
            {
                let words = self.chromium.last_words();
                let cause = format!("{what} for more than {} s{words}", limit.as_secs());
                return Err(self.fail(failure(cause)));
            }
        }
    }

    /// Records that no further message can come.
    fn fail(&mut self, error: Error) -> Error {
        let message = error.message();
        let cause = message.strip_prefix(error.subject()).unwrap_or(&message);
        self.broken = Some(cause.trim_start_matches([':', ' ']).to_owned());
        error
    }

    /// Answers a request. A request for the next job stays open, and its message is returned.
    fn answer(&mut self, request: HttpRequest) -> Result<Option<Message>> {
        let name = request.url.strip_prefix(self.root.as_str());
        let file = name.and_then(|name| FILES.iter().find(|(file, ..)| *file == name));
        match (&request.method, name, file) {
            (&Method::GET, _, Some((_, kind, text))) => request.send(kind, *text),
            (&Method::POST, Some("next"), _) => {
                let message = unpack(&request.body);
                self.waiting = Some(request);
                return message.map(Some).ok_or_else(|| failure("its page sent no message"));
            }
            (&Method::POST, Some("alive"), _) => request.finish(StatusCode::NO_CONTENT),
            _ => request.finish(StatusCode::NOT_FOUND),
        }
        Ok(None)
    }
}

/// The bytes of a message, in the format that page.js describes.
fn pack(head: &Value, payload: &[&[u8]]) -> Vec<u8> {
    let text = head.to_string();
    let padded = (4 + text.len()).next_multiple_of(16) - 4;
    let mut bytes = (padded as u32).to_le_bytes().to_vec();
    bytes.extend_from_slice(text.as_bytes());
    bytes.resize(4 + padded, b' ');
    payload.iter().for_each(|part| bytes.extend_from_slice(part));
    bytes
}

fn unpack(bytes: &[u8]) -> Option<Message> {
    let (length, rest) = bytes.split_first_chunk()?;
    let (head, payload) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    Some(Message { head: serde_json::from_slice(head).ok()?, payload: payload.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_as_they_were_written() {
        let head = serde_json::json!({ "job": "draw", "size": [3, 4] });
        let bytes = pack(&head, &[&[1, 2], &[3]]);
        assert_eq!((bytes.len() - 3) % 16, 0);
        let message = unpack(&bytes).expect("a message");
        assert_eq!((message.head, message.payload), (head, vec![1, 2, 3]));
        for broken in [&bytes[..3], &bytes[..20], b"\x04\0\0\0nope"] {
            assert!(unpack(broken).is_none());
        }
    }
}
