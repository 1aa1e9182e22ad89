//! Connections: how many there are, how long each may take over what, HTTP/1.1 or HTTP/2 over each, and how they end.
//!
//! One clock a connection says when it has run out: a header must come within `header_timeout` of the connection or of
//! its own first byte (a TLS handshake included), the next request within `idle_timeout`, and each piece of an answer
//! must be taken within `write_timeout`. While a request is worked on the limits of `http` hold.
//!
//! What a connection may take: with HTTP/1.1 two buffers of 16 KiB; with HTTP/2 256 KiB of bodies that nobody has read
//! yet, and of each of 32 streams 16 KiB of headers and two pieces of 16 KiB of an answer: 1.75 MiB; TLS adds 0.1 MiB.
//! Answers themselves are held by their requests, which `http` bounds.

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
/// What of bodies may lie unread: at 20 ms to the client and back, 13 MB a second.
const WINDOW_BYTES: u32 = 256 << 10;
/// What of an answer may wait for the client to take it, besides one piece.
const MAX_SEND_BYTES: usize = 16 << 10;
/// Streams that a client may open and reset before the connection ends.
const MAX_RESET_STREAMS: usize = 20;
/// How often a client of HTTP/2 is asked whether it is there; as long again it has to answer.
const PING_EVERY: Duration = Duration::from_secs(20);
/// What of an answer a client must take in each `write_timeout`: 0.5 kB a second.
const PIECE_BYTES: usize = 16 << 10;
/// How long requests in flight may take to end at shutdown.
const SHUTDOWN_PATIENCE: Duration = Duration::from_secs(20);
/// How long the last bytes of an answer may take to leave at shutdown.
const FAREWELL: Duration = Duration::from_secs(2);
/// How long nothing is accepted after that failed: the machine may be out of descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(500);

/// Serve whoever connects until `shutdown` turns true; then let what runs end, for 20 s at most.
pub async fn serve(
    listener: TcpListener,
    tls: Option<watch::Receiver<Arc<ServerConfig>>>,
    router: Router,
    limits: &Limits,
    mut shutdown: watch::Receiver<bool>,
) {
    let seats = Arc::new(Seats { most: limits.max_connections, taken: Mutex::default() });
    let patience =
        Patience { header: limits.header_timeout, idle: limits.idle_timeout, write: limits.write_timeout };
    let speaker = Speaker::new(router);
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
        // One too many is closed at once: whoever waited in the dark would come again all the same.
        let Some(seat) = Seats::take(&seats, network(peer.ip())) else { continue };
        // Of no consequence where it can't be set.
        let _ = stream.set_nodelay(true);
        let tls = tls.as_ref().map(|tls| TlsAcceptor::from(Arc::clone(&tls.borrow())));
        let attending = speaker.clone().attend(stream, tls, patience, shutdown.clone());
        connections.spawn(async move {
            attending.await;
            drop(seat);
        });
    }
    drop(listener);
    let rest = async { while connections.join_next().await.is_some() {} };
    // Those that are left end with the set.
    let _ = tokio::time::timeout(SHUTDOWN_PATIENCE, rest).await;
}

/// Who is connected. An address may have as many connections as are still free: one alone gets half of them, and
/// leaves as many to others.
struct Seats {
    most: usize,
    taken: Mutex<HashMap<IpAddr, usize>>,
}

/// Whom connections of an address count for: with IPv6 the network, all of which one machine has.
fn network(peer: IpAddr) -> IpAddr {
    match peer.to_canonical() {
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() & !(u128::from(u64::MAX))).into(),
        v4 => v4,
    }
}

/// A connection's place, given back when dropped.
struct Seat {
    seats: Arc<Seats>,
    peer: IpAddr,
}

impl Seats {
    fn take(seats: &Arc<Self>, peer: IpAddr) -> Option<Seat> {
        let mut taken = seats.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let free = seats.most.saturating_sub(taken.values().sum());
        let own = taken.get(&peer).copied().unwrap_or(0);
        (own < free).then(|| {
            taken.insert(peer, own + 1);
            Seat { seats: Arc::clone(seats), peer }
        })
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut taken = self.seats.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = taken.get_mut(&self.peer) {
            *own -= 1;
            if *own == 0 {
                taken.remove(&self.peer);
            }
        }
    }
}

/// Speaks HTTP over connections.
#[derive(Clone)]
struct Speaker {
    http1: auto::Builder<TokioExecutor>,
    http2: auto::Builder<TokioExecutor>,
    router: Router,
}

impl Speaker {
    fn new(router: Router) -> Self {
        // Which of the two is settled by the handshake. Without TLS it would have to be told from the first bytes, and
        // HTTP/2 without TLS is nobody's habit.
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

    /// Serve one connection until either side ends it or its clock has run out.
    async fn attend(
        self,
        stream: TcpStream,
        tls: Option<TlsAcceptor>,
        patience: Patience,
        shutdown: watch::Receiver<bool>,
    ) {
        let clock = Clock::start(patience);
        let stream = Watched { stream, clock: Arc::clone(&clock) };
        let talking = async {
            match tls {
                None => self.talk(&self.http1, stream, &clock, shutdown.clone()).await,
                Some(tls) => {
                    // Who fails at the handshake has been told by it.
                    let Ok(stream) = tls.accept(stream).await else { return };
                    if stream.get_ref().1.alpn_protocol() == Some(b"h2") {
                        clock.look_at_requests_only();
                        self.talk(&self.http2, stream, &clock, shutdown.clone()).await;
                    } else {
                        self.talk(&self.http1, stream, &clock, shutdown.clone()).await;
                    }
                }
            }
        };
        tokio::select! {
            () = talking => {}
            () = clock.run_out(shutdown.clone()) => {}
        }
    }

    async fn talk<S>(
        &self,
        builder: &auto::Builder<TokioExecutor>,
        stream: S,
        clock: &Arc<Clock>,
        mut shutdown: watch::Receiver<bool>,
    ) where
        S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        let router = TowerToHyperService::new(self.router.clone());
        let service = service_fn(|request| {
            let in_flight = clock.begin();
            let answering = router.call(request);
            async move {
                let answer = answering.await?;
                // With HTTP/2 the client may have no room for even the first piece.
                in_flight.handed_over();
                // The request lasts as long as the body of its answer.
                Ok::<_, Infallible>(answer.map(|body| Answer { body, left: Bytes::new(), in_flight }))
            }
        });
        let connection = builder.serve_connection(TokioIo::new(stream), service);
        tokio::pin!(connection);
        // Why a connection broke off is the client's business.
        tokio::select! {
            _ = connection.as_mut() => return,
            _ = shutdown.wait_for(|stop| *stop) => connection.as_mut().graceful_shutdown(),
        }
        let _ = connection.await;
    }
}

/// How long a client may take over what.
#[derive(Clone, Copy)]
struct Patience {
    header: Duration,
    idle: Duration,
    write: Duration,
}

/// What a connection waits for, and until when.
struct Clock {
    patience: Patience,
    state: Mutex<State>,
    changed: Notify,
}

struct State {
    /// Begun, and not all of the answer handed over.
    requests: usize,
    /// Ids of requests, and until when a piece of the answer may lie untaken.
    lying: Vec<(u64, Instant)>,
    next_id: u64,
    /// Whether the next byte begins a header.
    is_between_headers: bool,
    /// Whether bytes say anything about headers.
    sees_headers: bool,
    /// When the next request must have come, if none runs.
    until: Instant,
    /// Whether the end of an answer waits in our buffers: until it is taken, none of the next is read.
    end_lies: bool,
    closing: bool,
}

/// A request that runs.
struct InFlight {
    clock: Arc<Clock>,
    id: u64,
}

impl Clock {
    fn start(patience: Patience) -> Arc<Self> {
        let state = State {
            requests: 0,
            lying: Vec::new(),
            next_id: 0,
            is_between_headers: false,
            sees_headers: true,
            until: Instant::now() + patience.header,
            end_lies: false,
            closing: false,
        };
        Arc::new(Self { patience, state: Mutex::new(state), changed: Notify::new() })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes of HTTP/2 may be pings or parts of many streams: only whole requests count from now on.
    fn look_at_requests_only(&self) {
        self.state().sees_headers = false;
    }

    fn begin(self: &Arc<Self>) -> InFlight {
        let mut state = self.state();
        state.requests += 1;
        state.next_id += 1;
        InFlight { clock: Arc::clone(self), id: state.next_id }
    }

    fn read(&self) {
        let mut state = self.state();
        if state.is_between_headers && state.sees_headers && state.requests == 0 && !state.closing {
            state.is_between_headers = false;
            state.until = Instant::now() + self.patience.header;
            self.changed.notify_one();
        }
    }

    /// The client has no room for what is written.
    fn stuck(&self) {
        let mut state = self.state();
        if state.requests == 0 && !state.end_lies && !state.closing {
            state.end_lies = true;
            state.until = Instant::now() + self.patience.write;
            self.changed.notify_one();
        }
    }

    /// All that was written is gone.
    fn flushed(&self) {
        let mut state = self.state();
        if std::mem::take(&mut state.end_lies) && state.requests == 0 && !state.closing {
            state.until = Instant::now() + self.patience.idle;
        }
    }

    /// When the connection has run out, as things stand; none while only the service is waited for.
    fn deadline(&self) -> Option<Instant> {
        let state = self.state();
        match state.requests {
            0 => Some(state.until),
            _ => state.lying.iter().map(|(_, until)| *until).min(),
        }
    }

    fn close(&self) {
        let mut state = self.state();
        state.closing = true;
        state.until = Instant::now() + FAREWELL;
    }

    /// Resolves when the client has taken too long. At shutdown it has little time left unless a request runs.
    async fn run_out(&self, mut shutdown: watch::Receiver<bool>) {
        let mut closing = false;
        loop {
            let deadline = self.deadline();
            if deadline.is_some_and(|deadline| deadline <= Instant::now()) {
                return;
            }
            tokio::select! {
                () = tokio::time::sleep_until(deadline.unwrap_or_else(Instant::now)), if deadline.is_some() => {}
                () = self.changed.notified() => {}
                _ = shutdown.wait_for(|stop| *stop), if !closing => {
                    closing = true;
                    self.close();
                }
            }
        }
    }
}

impl InFlight {
    /// The client has room for more of the answer.
    fn taken(&self) {
        self.clock.state().lying.retain(|(id, _)| *id != self.id);
    }

    /// What the service has is waited for by nobody but the client.
    fn handed_over(&self) {
        self.clock.state().lying.push((self.id, Instant::now() + self.clock.patience.write));
        self.clock.changed.notify_one();
    }
}

impl Drop for InFlight {
    fn drop(&mut self) {
        self.taken();
        let mut state = self.clock.state();
        state.requests -= 1;
        if state.requests == 0 {
            state.is_between_headers = true;
            let patience = if state.closing { FAREWELL } else { self.clock.patience.idle };
            state.until = Instant::now() + patience;
            self.clock.changed.notify_one();
        }
    }
}

/// The body of an answer in pieces, none of which is asked for before the client has taken most of those before it:
/// what is asked for so tells how the client gets on.
struct Answer {
    body: Body,
    left: Bytes,
    in_flight: InFlight,
}

impl hyper::body::Body for Answer {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        self.in_flight.taken();
        if self.left.is_empty() {
            match ready!(Pin::new(&mut self.body).poll_frame(context)).transpose()?.map(Frame::into_data) {
                Some(Ok(data)) => self.left = data,
                Some(Err(other)) => return Poll::Ready(Some(Ok(other))),
                None => return Poll::Ready(None),
            }
        }
        let bytes = self.left.len().min(PIECE_BYTES);
        let piece = self.left.split_to(bytes);
        self.in_flight.handed_over();
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

/// A stream that tells its clock what happens on it.
struct Watched {
    stream: TcpStream,
    clock: Arc<Clock>,
}

impl AsyncRead for Watched {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        if buffer.filled().len() > before {
            self.clock.read();
        }
        read
    }
}

impl AsyncWrite for Watched {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        if written.is_pending() {
            self.clock.stuck();
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
            self.clock.stuck();
        }
        written
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        // Asked for when the buffers above are empty.
        let flushed = Pin::new(&mut self.stream).poll_flush(context);
        if flushed.is_ready() {
            self.clock.flushed();
        }
        flushed
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
