//! HTTP on a local port: requests come one after another to whoever asks for them, and lie unanswered as long as need be.
//!
//! A browser opens several connections at once and keeps them open, so none may cost another its turn: each is a task of a
//! runtime, not a thread of a pool.

use std::convert::Infallible;
use std::fmt::Display;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{CACHE_CONTROL, CONTENT_TYPE};
use hyper::server::conn::http1;
use hyper::service::service_fn;
pub(super) use hyper::{Method, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::net::TcpListener;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;

/// Most bytes of a message; a band of a picture has some ten million.
const LARGEST: usize = 1 << 30;

/// An open port. Its end closes all connections.
pub(super) struct Server {
    address: SocketAddr,
    requests: Receiver<HttpRequest>,
    runtime: Option<Runtime>,
}

/// A request that waits for its answer; dropped without one, the page gets 404.
pub(super) struct HttpRequest {
    pub(super) method: Method,
    /// Path and query, as sent.
    pub(super) url: String,
    pub(super) body: Vec<u8>,
    answer: oneshot::Sender<Response>,
}

type Response = hyper::Response<Full<Bytes>>;

impl Server {
    /// Opens a port of this machine alone, any free one for 0.
    pub(super) fn open(port: u16) -> io::Result<Server> {
        let runtime = Builder::new_multi_thread().worker_threads(1).enable_io().build()?;
        let listener = runtime.block_on(TcpListener::bind((Ipv4Addr::LOCALHOST, port)))?;
        let address = listener.local_addr()?;
        let (sender, requests) = channel();
        runtime.spawn(accept(listener, sender));
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
    /// Sends a text or other content of a type; a page that went away needs none.
    pub(super) fn send(self, kind: &'static str, content: impl Into<Bytes>) {
        let response = hyper::Response::builder()
            .header(CONTENT_TYPE, kind)
            // what is made anew under the same address is to be seen
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

async fn accept(listener: TcpListener, requests: Sender<HttpRequest>) {
    loop {
        // a connection that broke before it was taken
        let Ok((stream, _)) = listener.accept().await else { continue };
        let requests = requests.clone();
        let service = service_fn(move |request| serve(request, requests.clone()));
        tokio::spawn(http1::Builder::new().serve_connection(TokioIo::new(stream), service));
    }
}

async fn serve(
    request: hyper::Request<Incoming>,
    requests: Sender<HttpRequest>,
) -> Result<Response, Infallible> {
    let (head, body) = request.into_parts();
    // a message that broke off is none
    let Ok(body) = Limited::new(body, LARGEST).collect().await else {
        return Ok(empty(StatusCode::BAD_REQUEST));
    };
    let (answer, answered) = oneshot::channel();
    let (method, url) = (head.method, head.uri.to_string());
    let _ = requests.send(HttpRequest { method, url, body: body.to_bytes().into(), answer });
    Ok(answered.await.unwrap_or_else(|_| empty(StatusCode::NOT_FOUND)))
}

fn empty(status: StatusCode) -> Response {
    let mut response = Response::default();
    *response.status_mut() = status;
    response
}
