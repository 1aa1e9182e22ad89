//! Connections: how many there are, how long each may take over what, HTTP/1.1 or HTTP/2 over each, and how they end.
//!
//! A timer per connection ends it: a header must come within `header_timeout` of the connection or of its own first byte
//! (a TLS handshake included), the next request within `idle_timeout`, and each piece of a response must be taken within
//! `write_timeout`. While a request is worked on the limits of `http` hold.
//!
//! What a connection may take: with HTTP/1.1 two buffers of 16 KiB; with HTTP/2 256 KiB of bodies that nobody has read
//! yet, and of each of 32 streams 16 KiB of headers and two pieces of 16 KiB of a response: 1.75 MiB; TLS adds 0.1 MiB.
//! Responses themselves are held by their requests, which `http` bounds.

use std::collections::HashMap;
use std::convert::Infallible;
use std::io;
use std::net::{IpAddr, Ipv6Addr};
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use bytes::Bytes;
use hyper::body::{Frame, SizeHint};
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use hyper_util::server::conn::auto;
use hyper_util::service::TowerToHyperService;
use rustls::ServerConfig;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, watch};
use tokio::task::JoinSet;
use tokio::time::Instant;
use tokio_rustls::TlsAcceptor;

use crate::config::Limits;

/// Longest header of a request.
const MAX_HEADER_BYTES: usize = 16 << 10;
/// Requests that a connection may have at once with HTTP/2: more than a camera's worth.
const MAX_STREAMS: u32 = 32;
/// Flow-control window of HTTP/2, unread bytes of bodies: at 20 ms to the client and back, 13 MB a second.
const WINDOW_BYTES: u32 = 256 << 10;
/// Bytes of a response that may wait in hyper for the client to take them, besides one piece.
const MAX_SEND_BYTES: usize = 16 << 10;
/// Streams that a client may open and reset before the connection ends.
const MAX_RESET_STREAMS: usize = 20;
/// Time between two pings of a client of HTTP/2, and the time that it has to answer one.
const PING_EVERY: Duration = Duration::from_secs(20);
/// Bytes of a response that a client must take in each `write_timeout`: 0.5 kB a second.
const PIECE_BYTES: usize = 16 << 10;
/// Longest time that requests in flight may take to end at shutdown.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(20);
/// Longest time that the last bytes of a response may take to leave at shutdown.
const LINGER_TIMEOUT: Duration = Duration::from_secs(2);
/// Pause after a failed accept: the machine may be out of descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(500);

/// Serves every connection until `shutdown` turns true; then waits for running requests, for 20 s at most.
pub async fn serve(
    listener: TcpListener,
    tls: Option<watch::Receiver<Arc<ServerConfig>>>,
    router: Router,
    limits: &Limits,
    mut shutdown: watch::Receiver<bool>,
) {
    let limiter = Arc::new(ConnectionLimiter { most: limits.max_connections, open: Mutex::default() });
    let timeouts =
        Timeouts { header: limits.header_timeout, idle: limits.idle_timeout, write: limits.write_timeout };
    let server = HttpServer::new(router);
    let mut connections = JoinSet::new();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            Some(_) = connections.join_next() => continue,
            _ = shutdown.wait_for(|stop| *stop) => break,
        };
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                tracing::warn!(%error, "can't accept connections");
                tokio::time::sleep(ACCEPT_PAUSE).await;
                continue;
            }
        };
        // One too many is closed at once: a client that is kept waiting without a word would come again all the same.
        let Some(permit) = limiter.acquire(network(peer.ip())) else { continue };
        // Of no consequence where it can't be set.
        let _ = stream.set_nodelay(true);
        let tls = tls.as_ref().map(|tls| TlsAcceptor::from(Arc::clone(&tls.borrow())));
        let serving = server.clone().serve_connection(stream, tls, timeouts, shutdown.clone());
        connections.spawn(async move {
            serving.await;
            drop(permit);
        });
    }
    drop(listener);
    let rest = async { while connections.join_next().await.is_some() {} };
    // Those that are left end with the set.
    let _ = tokio::time::timeout(SHUTDOWN_TIMEOUT, rest).await;
}

/// Limits connections in all and of each address. An address may have as many as are still free: one alone gets half of
/// them, and leaves as many to others.
struct ConnectionLimiter {
    most: usize,
    open: Mutex<HashMap<IpAddr, usize>>,
}

/// The address that a peer's connections count for: with IPv6 its network, all of which one machine has.
fn network(peer: IpAddr) -> IpAddr {
    match peer.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() & !(u128::from(u64::MAX))).into(),
        v4 => v4,
    }
}

/// One connection that counts against the limiter until it is dropped.
struct ConnectionPermit {
    limiter: Arc<ConnectionLimiter>,
    peer: IpAddr,
}

impl ConnectionLimiter {
    fn acquire(self: &Arc<Self>, peer: IpAddr) -> Option<ConnectionPermit> {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let free = self.most.saturating_sub(open.values().sum());
        let own = open.get(&peer).copied().unwrap_or(0);
        (own < free).then(|| {
            open.insert(peer, own + 1);
            ConnectionPermit { limiter: Arc::clone(self), peer }
        })
    }
}

impl Drop for ConnectionPermit {
    fn drop(&mut self) {
        let mut open = self.limiter.open.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = open.get_mut(&self.peer) {
            *own -= 1;
            if *own == 0 {
                open.remove(&self.peer);
            }
        }
    }
}

/// HTTP/1.1 and HTTP/2 over connections.
#[derive(Clone)]
struct HttpServer {
    http1: auto::Builder<TokioExecutor>,
    http2: auto::Builder<TokioExecutor>,
    router: Router,
}

impl HttpServer {
    fn new(router: Router) -> Self {
        // The TLS handshake decides between the two. Without TLS the first bytes would have to, and nobody speaks HTTP/2
        // without TLS.
        let mut http1 = auto::Builder::new(TokioExecutor::new()).http1_only();
        http1.http1().max_buf_size(MAX_HEADER_BYTES);
        let mut http2 = auto::Builder::new(TokioExecutor::new()).http2_only();
        http2
            .http2()
            .timer(TokioTimer::new())
            .max_concurrent_streams(MAX_STREAMS)
            .max_header_list_size(MAX_HEADER_BYTES as u32)
            .initial_stream_window_size(WINDOW_BYTES)
            .initial_connection_window_size(WINDOW_BYTES)
            .max_send_buf_size(MAX_SEND_BYTES)
            .max_pending_accept_reset_streams(MAX_RESET_STREAMS)
            .max_local_error_reset_streams(MAX_RESET_STREAMS)
            .keep_alive_interval(PING_EVERY)
            .keep_alive_timeout(PING_EVERY);
        Self { http1, http2, router }
    }

    /// Serves one connection until either side ends it or its timer expires.
    async fn serve_connection(
        self,
        stream: TcpStream,
        tls: Option<TlsAcceptor>,
        timeouts: Timeouts,
        shutdown: watch::Receiver<bool>,
    ) {
        let timer = ConnectionTimer::start(timeouts);
        let stream = TimedStream { stream, timer: Arc::clone(&timer) };
        let serving = async {
            match tls {
                None => self.serve_http(&self.http1, stream, &timer, shutdown.clone()).await,
                Some(tls) => {
                    // The handshake itself has told the client why it failed.
                    let Ok(stream) = tls.accept(stream).await else { return };
                    if stream.get_ref().1.alpn_protocol() == Some(b"h2") {
                        timer.ignore_bytes();
                        self.serve_http(&self.http2, stream, &timer, shutdown.clone()).await;
                    } else {
                        self.serve_http(&self.http1, stream, &timer, shutdown.clone()).await;
                    }
                }
            }
        };
        tokio::select! {
            () = serving => {}
            () = timer.expired(shutdown.clone()) => {}
        }
    }

    async fn serve_http<S>(
        &self,
        builder: &auto::Builder<TokioExecutor>,
        stream: S,
        timer: &Arc<ConnectionTimer>,
        mut shutdown: watch::Receiver<bool>,
    ) where
        S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        let router = TowerToHyperService::new(self.router.clone());
        let service = service_fn(|request| {
            let in_flight = timer.begin();
            let responding = router.call(request);
            async move {
                let response = responding.await?;
                // With HTTP/2 the client may have no room for even the first piece.
                in_flight.start_write();
                // The request lasts as long as the body of its response.
                Ok::<_, Infallible>(response.map(|body| TimedBody { body, left: Bytes::new(), in_flight }))
            }
        });
        let connection = builder.serve_connection(TokioIo::new(stream), service);
        tokio::pin!(connection);
        // Nobody needs the error of a connection that broke off.
        tokio::select! {
            _ = connection.as_mut() => return,
            _ = shutdown.wait_for(|stop| *stop) => connection.as_mut().graceful_shutdown(),
        }
        let _ = connection.await;
    }
}

/// Longest times that a client may take.
#[derive(Clone, Copy)]
struct Timeouts {
    header: Duration,
    idle: Duration,
    write: Duration,
}

/// The time at which a connection is closed, by what it waits for.
struct ConnectionTimer {
    timeouts: Timeouts,
    state: Mutex<State>,
    changed: Notify,
}

struct State {
    /// Requests that have begun and whose response is not complete.
    requests: usize,
    /// Pieces of responses that the client has not taken yet.
    writes: Vec<PendingWrite>,
    next_id: u64,
    /// Whether the next byte begins a header.
    is_between_headers: bool,
    /// Whether bytes that arrive are those of headers and bodies alone.
    watches_bytes: bool,
    /// The deadline while no request runs.
    deadline: Instant,
    /// Whether the end of a response waits in our buffers: until it is taken, none of the next is read.
    is_end_pending: bool,
    is_closing: bool,
}

/// A piece of a response that the client must take before the deadline.
struct PendingWrite {
    request: u64,
    deadline: Instant,
}

/// A request that runs.
struct InFlight {
    timer: Arc<ConnectionTimer>,
    id: u64,
}

impl ConnectionTimer {
    fn start(timeouts: Timeouts) -> Arc<Self> {
        let state = State {
            requests: 0,
            writes: Vec::new(),
            next_id: 0,
            is_between_headers: false,
            watches_bytes: true,
            deadline: Instant::now() + timeouts.header,
            is_end_pending: false,
            is_closing: false,
        };
        Arc::new(Self { timeouts, state: Mutex::new(state), changed: Notify::new() })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on bytes don't restart the timer: those of HTTP/2 may be pings or parts of many streams.
    fn ignore_bytes(&self) {
        self.state().watches_bytes = false;
    }

    fn begin(self: &Arc<Self>) -> InFlight {
        let mut state = self.state();
        state.requests += 1;
        state.next_id += 1;
        InFlight { timer: Arc::clone(self), id: state.next_id }
    }

    /// Bytes have arrived: the first of a header starts `header_timeout`.
    fn read(&self) {
        let mut state = self.state();
        if state.is_between_headers && state.watches_bytes && state.requests == 0 && !state.is_closing {
            state.is_between_headers = false;
            state.deadline = Instant::now() + self.timeouts.header;
            self.changed.notify_one();
        }
    }

    /// The client takes no bytes now.
    fn blocked(&self) {
        let mut state = self.state();
        if state.requests == 0 && !state.is_end_pending && !state.is_closing {
            state.is_end_pending = true;
            state.deadline = Instant::now() + self.timeouts.write;
            self.changed.notify_one();
        }
    }

    /// The client has taken all that was written.
    fn flushed(&self) {
        let mut state = self.state();
        if std::mem::take(&mut state.is_end_pending) && state.requests == 0 && !state.is_closing {
            state.deadline = Instant::now() + self.timeouts.idle;
        }
    }

    /// When the connection is closed, as things stand; none while it waits for the service alone.
    fn deadline(&self) -> Option<Instant> {
        let state = self.state();
        match state.requests {
            0 => Some(state.deadline),
            _ => state.writes.iter().map(|write| write.deadline).min(),
        }
    }

    fn close(&self) {
        let mut state = self.state();
        state.is_closing = true;
        state.deadline = Instant::now() + LINGER_TIMEOUT;
    }

    /// Resolves when the client has taken too long. At shutdown it gets [`LINGER_TIMEOUT`] unless a request runs.
    async fn expired(&self, mut shutdown: watch::Receiver<bool>) {
        let mut is_closing = false;
        loop {
            let deadline = self.deadline();
            if deadline.is_some_and(|deadline| deadline <= Instant::now()) {
                return;
            }
            tokio::select! {
                () = tokio::time::sleep_until(deadline.unwrap_or_else(Instant::now)), if deadline.is_some() => {}
                () = self.changed.notified() => {}
                _ = shutdown.wait_for(|stop| *stop), if !is_closing => {
                    is_closing = true;
                    self.close();
                }
            }
        }
    }
}

impl InFlight {
    /// The client has taken the last piece of the response.
    fn end_write(&self) {
        self.timer.state().writes.retain(|write| write.request != self.id);
    }

    /// The service has given a piece of the response: from now on the connection waits for the client.
    fn start_write(&self) {
        let deadline = Instant::now() + self.timer.timeouts.write;
        self.timer.state().writes.push(PendingWrite { request: self.id, deadline });
        self.timer.changed.notify_one();
    }
}

impl Drop for InFlight {
    fn drop(&mut self) {
        self.end_write();
        let mut state = self.timer.state();
        state.requests -= 1;
        if state.requests == 0 {
            state.is_between_headers = true;
            let timeout = if state.is_closing { LINGER_TIMEOUT } else { self.timer.timeouts.idle };
            state.deadline = Instant::now() + timeout;
            self.timer.changed.notify_one();
        }
    }
}

/// The body of a response in pieces. Hyper polls for a piece when the client has taken most of those before it: each poll
/// resets the timer.
struct TimedBody {
    body: Body,
    left: Bytes,
    in_flight: InFlight,
}

impl hyper::body::Body for TimedBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        self.in_flight.end_write();
        if self.left.is_empty() {
            match ready!(Pin::new(&mut self.body).poll_frame(context)).transpose()?.map(Frame::into_data) {
                Some(Ok(data)) => self.left = data,
                Some(Err(other)) => return Poll::Ready(Some(Ok(other))),
                None => return Poll::Ready(None),
            }
        }
        let bytes = self.left.len().min(PIECE_BYTES);
        let piece = self.left.split_to(bytes);
        self.in_flight.start_write();
        Poll::Ready(Some(Ok(Frame::data(piece))))
    }

    fn is_end_stream(&self) -> bool {
        self.left.is_empty() && self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        let (left, hint) = (self.left.len() as u64, self.body.size_hint());
        let mut whole = SizeHint::new();
        whole.set_lower(hint.lower() + left);
        if let Some(upper) = hint.upper() {
            whole.set_upper(upper + left);
        }
        whole
    }
}

/// A stream that reports reads and writes to the timer.
struct TimedStream {
    stream: TcpStream,
    timer: Arc<ConnectionTimer>,
}

impl AsyncRead for TimedStream {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        if buffer.filled().len() > before {
            self.timer.read();
        }
        read
    }
}

impl AsyncWrite for TimedStream {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        if written.is_pending() {
            self.timer.blocked();
        }
        written
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        pieces: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, pieces);
        if written.is_pending() {
            self.timer.blocked();
        }
        written
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        // Called when the buffers above are empty.
        let flushed = Pin::new(&mut self.stream).poll_flush(context);
        if flushed.is_ready() {
            self.timer.flushed();
        }
        flushed
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
