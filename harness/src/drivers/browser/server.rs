//! HTTP on a local port. Requests are handed out one after another, and may stay unanswered for any time.
//!
//! A browser opens several connections at once and keeps them open. So that no connection blocks another, each is a task of an
//! async runtime, not a thread of a pool.

use std::convert::Infallible;
use std::fmt::Display;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{CACHE_CONTROL, CONTENT_LENGTH, CONTENT_TYPE, HOST, HeaderMap, ORIGIN};
use hyper::server::conn::http1;
use hyper::service::service_fn;
pub(super) use hyper::{Method, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::net::TcpListener;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;

/// An open port. Dropping it closes all connections.
pub(super) struct Server {
    address: SocketAddr,
    requests: Receiver<HttpRequest>,
    runtime: Option<Runtime>,
}

/// A request that waits for its answer. If it is dropped without one, the page gets 404.
pub(super) struct HttpRequest {
    pub(super) method: Method,
    /// Path and query, as sent.
    pub(super) url: String,
    pub(super) body: Vec<u8>,
    answer: oneshot::Sender<Response>,
}

type Response = hyper::Response<Full<Bytes>>;

impl Server {
    /// Opens a port for this machine only; 0: any free port. `max_bytes`: maximum size of a message.
    pub(super) fn open(port: u16, max_bytes: usize) -> io::Result<Server> {
        let runtime = Builder::new_multi_thread().worker_threads(1).enable_io().build()?;
        let listener = runtime.block_on(TcpListener::bind((Ipv4Addr::LOCALHOST, port)))?;
        let address = listener.local_addr()?;
        let (sender, requests) = channel();
        runtime.spawn(accept(listener, sender, max_bytes));
        Ok(Server { address, requests, runtime: Some(runtime) })
    }

    pub(super) fn address(&self) -> impl Display {
        self.address
    }

    /// The next request, if one comes in time.
    pub(super) fn next(&self, wait: Duration) -> io::Result<Option<HttpRequest>> {
        match self.requests.recv_timeout(wait) {
            Ok(request) => Ok(Some(request)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(e @ RecvTimeoutError::Disconnected) => Err(io::Error::other(e)),
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

impl HttpRequest {
    /// Sends content of a type. If the page is gone, nothing happens.
    pub(super) fn send(self, kind: &'static str, content: impl Into<Bytes>) {
        let response = hyper::Response::builder()
            .header(CONTENT_TYPE, kind)
            // a rebuilt file under the same address must not come from the browser's cache
            .header(CACHE_CONTROL, "no-cache")
            .body(Full::new(content.into()));
        if let Ok(response) = response {
            let _ = self.answer.send(response);
        }
    }

    /// Sends a status alone.
    pub(super) fn finish(self, status: StatusCode) {
        let _ = self.answer.send(empty(status));
    }
}

async fn accept(listener: TcpListener, requests: Sender<HttpRequest>, max_bytes: usize) {
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // the connection broke before it was accepted, or all descriptors are in use, which lasts a while
            std::thread::sleep(Duration::from_millis(20));
            continue;
        };
        let requests = requests.clone();
        let service = service_fn(move |request| serve(request, requests.clone(), max_bytes));
        tokio::spawn(http1::Builder::new().serve_connection(TokioIo::new(stream), service));
    }
}

async fn serve(
    request: hyper::Request<Incoming>,
    requests: Sender<HttpRequest>,
    max_bytes: usize,
) -> Result<Response, Infallible> {
    let (head, body) = request.into_parts();
    if !is_own(&head.headers) {
        return Ok(empty(StatusCode::FORBIDDEN));
    }
    let length = head.headers.get(CONTENT_LENGTH).and_then(|text| text.to_str().ok()?.parse().ok());
    if length.is_some_and(|length: usize| length > max_bytes) {
        return Ok(empty(StatusCode::PAYLOAD_TOO_LARGE));
    }
    // an incomplete message is dropped
    let Ok(body) = Limited::new(body, max_bytes).collect().await else {
        return Ok(empty(StatusCode::BAD_REQUEST));
    };
    let (answer, answered) = oneshot::channel();
    let (method, url) = (head.method, head.uri.to_string());
    let _ = requests.send(HttpRequest { method, url, body: body.to_bytes().into(), answer });
    Ok(answered.await.unwrap_or_else(|_| empty(StatusCode::NOT_FOUND)))
}

/// Whether a request is for this machine by name, and not from another site's page. A site that makes its own name point to
/// this machine could otherwise read what is served here (DNS rebinding).
fn is_own(headers: &HeaderMap) -> bool {
    let text = |name| headers.get(name).map(|value| value.to_str().unwrap_or_default());
    let from = text(ORIGIN).map(|origin| origin.strip_prefix("http://").unwrap_or_default());
    text(HOST).is_some_and(is_local) && from.is_none_or(is_local)
}

/// Whether a host, with or without a port, is this machine.
fn is_local(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    ["127.0.0.1", "localhost", "[::1]"].iter().any(|own| name.eq_ignore_ascii_case(own))
}

fn empty(status: StatusCode) -> Response {
    let mut response = Response::default();
    *response.status_mut() = status;
    response
}
