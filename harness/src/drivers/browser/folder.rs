//! Serves a folder of files over HTTP, to browsers on this machine.

use std::fs;
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use diffraction_shaders::error::{Error, Result};

use super::server::{HttpRequest, Method, Server, StatusCode};

/// Content types by file extension. Browsers need them for scripts and styles.
const TYPES: [(&str, &str); 7] = [
    ("html", "text/html; charset=utf-8"),
    ("js", "text/javascript; charset=utf-8"),
    ("css", "text/css; charset=utf-8"),
    ("json", "application/json"),
    ("png", "image/png"),
    ("glsl", "text/plain; charset=utf-8"),
    ("wgsl", "text/plain; charset=utf-8"),
];

/// Maximum size of what a page posts, in bytes: results as text.
const MAX_BYTES: usize = 16 << 20;

/// Serves a folder on a local port, to pages of this machine. Files outside the folder are never read, not even through links,
/// and neither are hidden files.
pub struct FolderServer {
    server: Server,
    root: PathBuf,
}

impl FolderServer {
    /// Opens a port; 0: any free port.
    pub fn open(folder: &Path, port: u16) -> Result<FolderServer> {
        let about = |cause: &str| Error::new(folder.display(), cause);
        let root = fs::canonicalize(folder).map_err(|e| about("cannot be opened").source(e))?;
        if !root.is_dir() {
            return Err(about("is not a folder"));
        }
        let server = Server::open(port, MAX_BYTES).map_err(|e| {
            Error::new(format!("port {port}"), "cannot be opened")
                .remedy("another program may use it: choose another port, or 0 for any free one")
                .source(e)
        })?;
        Ok(FolderServer { server, root })
    }

    /// The folder's address, with a slash at its end.
    pub fn address(&self) -> String {
        format!("http://{}/", self.server.address())
    }

    /// Answers the next request, if one comes in time. Returns what a page posts. All other requests get files.
    pub fn answer(&self, wait: Duration) -> Result<Option<Vec<u8>>> {
        let failed = |e| Error::new("the local port", "cannot take requests").source(e);
        let Some(request) = self.server.next(wait).map_err(failed)? else { return Ok(None) };
        Ok(self.respond(request))
    }

    fn respond(&self, mut request: HttpRequest) -> Option<Vec<u8>> {
        match request.method {
            Method::POST => {
                let posted = std::mem::take(&mut request.body);
                request.finish(StatusCode::NO_CONTENT);
                return Some(posted);
            }
            Method::GET | Method::HEAD => match self.file(&request.url) {
                Some((bytes, kind)) => request.send(kind, bytes),
                None => request.finish(StatusCode::NOT_FOUND),
            },
            _ => request.finish(StatusCode::METHOD_NOT_ALLOWED),
        }
        None
    }

    /// The bytes and the content type of a file below the folder.
    fn file(&self, url: &str) -> Option<(Vec<u8>, &'static str)> {
        let relative = relative(url)?;
        let mut path = fs::canonicalize(self.root.join(relative)).ok()?;
        if path.is_dir() {
            path = fs::canonicalize(path.join("index.html")).ok()?;
        }
        // a pipe or a device would never end
        if !path.starts_with(&self.root) || !path.is_file() {
            return None;
        }
        let end = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let kind = TYPES.iter().find(|(name, _)| *name == end);
        let kind = kind.map_or("application/octet-stream", |(_, kind)| kind);
        Some((fs::read(&path).ok()?, kind))
    }
}

/// The relative path of an address; `None` if a part is empty, hidden or leads upwards.
fn relative(url: &str) -> Option<PathBuf> {
    let path = url.split(['?', '#']).next()?.strip_prefix('/')?;
    let path = PathBuf::from(decode(path)?);
    let is_shown = |part: Component<'_>| match part {
        Component::Normal(name) => !name.as_encoded_bytes().starts_with(b"."),
        _ => false,
    };
    path.components().all(is_shown).then_some(path)
}

/// Decodes `%41` to `A`; `None` if the result is not valid text.
fn decode(text: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first == b'%' {
            let digits = tail.split_at_checked(2)?;
            let number = u8::from_str_radix(std::str::from_utf8(digits.0).ok()?, 16).ok()?;
            bytes.push(number);
            rest = digits.1;
        } else {
            bytes.push(*first);
        }
    }
    String::from_utf8(bytes).ok().filter(|text| !text.contains('\0'))
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};
    use std::net::TcpStream;

    use super::*;

    fn get(server: &FolderServer, path: &str) -> String {
        let address = server.address();
        let host = address.strip_prefix("http://").expect("an address").trim_end_matches('/');
        let mut stream = TcpStream::connect(host).expect("the port is open");
        let request = format!("GET {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).expect("writes");
        assert!(server.answer(Duration::from_secs(10)).expect("answers").is_none());
        let mut text = String::new();
        stream.read_to_string(&mut text).expect("reads");
        text
    }

    #[test]
    fn only_files_of_the_folder_are_handed_out() {
        let place = tempfile::tempdir().expect("a folder");
        let root = place.path().join("page");
        fs::create_dir_all(root.join("a b")).expect("a folder");
        fs::write(root.join("index.html"), "first").expect("writes");
        fs::write(root.join("a b/x.js"), "script").expect("writes");
        fs::write(place.path().join("secret"), "secret").expect("writes");
        fs::create_dir(root.join(".git")).expect("a folder");
        fs::write(root.join(".git/config"), "secret").expect("writes");
        fs::write(root.join("a b/.hidden"), "secret").expect("writes");
        let server = FolderServer::open(&root, 0).expect("opens");
        for (path, body, kind) in [
            ("/", "first", "text/html"),
            ("/index.html?x=/../y#z", "first", "text/html"),
            ("/a%20b/x.js", "script", "text/javascript"),
        ] {
            let text = get(&server, path);
            assert!(text.starts_with("HTTP/1.1 200") && text.ends_with(body), "{path}: {text}");
            assert!(text.to_lowercase().contains(&format!("content-type: {kind}")), "{text}");
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(place.path().join("secret"), root.join("link")).expect("links");
        for path in [
            "/../secret",
            "/%2e%2e/secret",
            "/..%2fsecret",
            "/a%20b/../../secret",
            "//etc/passwd",
            "/link",
            "/.git/config",
            "/a%20b/.hidden",
            "/none",
            "/a%20b",
            "/%zz",
            "/%00",
        ] {
            let text = get(&server, path);
            assert!(!text.contains("secret\r\n") && !text.ends_with("secret"), "{path}: {text}");
            assert!(text.starts_with("HTTP/1.1 4"), "{path}: {text}");
        }
    }

    /// Another site's page, or a name that points to this machine, gets nothing; nor does a message without end.
    #[test]
    fn only_pages_of_this_machine_are_answered() {
        let place = tempfile::tempdir().expect("a folder");
        fs::write(place.path().join("x"), "body").expect("writes");
        let server = FolderServer::open(place.path(), 0).expect("opens");
        let address = server.address().replace("http://", "").replace('/', "");
        let port = address.rsplit(':').next().expect("a port").to_owned();
        let ask = |head: &str| {
            let mut stream = TcpStream::connect(&address).expect("the port is open");
            let request = format!("{head}\r\nconnection: close\r\n\r\n");
            stream.write_all(request.as_bytes()).expect("writes");
            // what is refused never comes here
            server.answer(Duration::from_millis(300)).expect("answers");
            let mut text = String::new();
            let _ = stream.read_to_string(&mut text);
            text
        };
        for head in [
            format!("GET /x HTTP/1.1\r\nhost: 127.0.0.1:{port}"),
            format!("GET /x HTTP/1.1\r\nhost: LocalHost:{port}\r\norigin: http://127.0.0.1:{port}"),
        ] {
            assert!(ask(&head).ends_with("body"), "{head}");
        }
        for head in [
            format!("GET /x HTTP/1.1\r\nhost: evil.example:{port}"),
            format!("GET /x HTTP/1.1\r\nhost: 127.0.0.1.evil.example:{port}"),
            format!("GET /x HTTP/1.1\r\nhost: localhost:{port}\r\norigin: http://evil.example"),
            format!("GET /x HTTP/1.1\r\nhost: localhost:{port}\r\norigin: null"),
        ] {
            assert!(ask(&head).starts_with("HTTP/1.1 403"), "{head}");
        }
        let long = format!(
            "POST / HTTP/1.1\r\nhost: localhost:{port}\r\ncontent-length: {}",
            MAX_BYTES + 1
        );
        assert!(ask(&long).starts_with("HTTP/1.1 413"), "{long}");
    }

    /// A browser opens several connections at once and keeps them open. Each must be answered meanwhile.
    #[test]
    fn connections_that_stay_open_starve_no_other() {
        const AT_ONCE: usize = 24;
        let place = tempfile::tempdir().expect("a folder");
        fs::write(place.path().join("x"), "body").expect("writes");
        for round in 0..20 {
            let server = FolderServer::open(place.path(), 0).expect("opens");
            let address = server.address().replace("http://", "").replace('/', "");
            let open = || TcpStream::connect(&address).expect("the port is open");
            let mut streams: Vec<TcpStream> = (0..AT_ONCE).map(|_| open()).collect();
            for stream in &mut streams {
                stream
                    .write_all(format!("GET /x HTTP/1.1\r\nhost: {address}\r\n\r\n").as_bytes())
                    .expect("writes");
            }
            for _ in 0..AT_ONCE {
                server.answer(Duration::from_secs(5)).expect("answers");
            }
            for (i, stream) in streams.iter_mut().enumerate() {
                stream.set_read_timeout(Some(Duration::from_secs(5))).expect("sets");
                let mut first = [0; 15];
                let read = stream.read_exact(&mut first);
                assert!(read.is_ok(), "round {round}: connection {i} gets no answer");
                assert_eq!(&first, b"HTTP/1.1 200 OK", "round {round}, connection {i}");
            }
        }
    }

    #[test]
    fn no_folder_and_no_port_are_errors() {
        let place = tempfile::tempdir().expect("a folder");
        assert!(FolderServer::open(&place.path().join("none"), 0).is_err());
        let server = FolderServer::open(place.path(), 0).expect("opens");
        let address = server.address().replace('/', "");
        let port = address.rsplit(':').next().expect("a port").parse().expect("a number");
        assert!(FolderServer::open(place.path(), port).is_err());
    }
}
