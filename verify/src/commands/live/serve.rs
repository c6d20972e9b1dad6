//! A page in the browser that shows finger, forces and latency while `live` runs.
//!
//! A small HTTP server: `GET /` returns the page; `GET /events` returns each line of JSON as a server-sent event. It is read-only. The evaluation of
//! frames never waits for the server: each client has a bounded queue, and events that do not fit into the queue are dropped.

use crate::commands::prelude::*;
use crate::commands::print_line;
use finray_model::finger::Plate;
use std::hash::{BuildHasher, RandomState};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The page. `NONCE` and `FINGERS` are replaced.
const PAGE: &str = include_str!("page.html");
/// Largest number of connections, and largest number of clients that receive events.
const LARGEST_CONNECTIONS: usize = 32;
const LARGEST_CLIENTS: usize = 16;
/// Largest number of events that wait for a client.
const QUEUE: usize = 256;
/// Largest size of a request, bytes, and the longest time until the whole request arrives.
const LARGEST_REQUEST: usize = 8192;
const REQUEST_LIMIT: Duration = Duration::from_secs(5);
/// Time after which a client that does not read is disconnected.
const WRITE_LIMIT: Duration = Duration::from_secs(10);
/// After this time without an event, a comment is sent to the client to detect a closed connection.
const HEARTBEAT: Duration = Duration::from_secs(5);
/// Longest time for which the server, at the end of the stream, waits for clients to receive the last events.
const FAREWELL: Duration = Duration::from_millis(500);

/// The undeformed finger that the page draws, mm, finger frame.
#[derive(Serialize)]
struct Drawing<'a> {
    name: &'a str,
    /// Points of plates and ribs.
    lines: Vec<Vec<[f64; 2]>>,
    /// Clamped end of the front plate, and unit vectors along the plate and along its inward normal.
    base: [f64; 2],
    along: [f64; 2],
    inward: [f64; 2],
}

/// The running server. When the server is dropped, clients receive the last events and the message that the stream has ended.
pub struct Server(Arc<Shared>);

struct Shared {
    address: SocketAddr,
    /// The drawings of the fingers as JSON.
    fingers: String,
    events: Mutex<Events>,
    connections: AtomicUsize,
    clients: AtomicUsize,
}

#[derive(Default)]
struct Events {
    queues: Vec<SyncSender<Arc<str>>>,
    /// The newest event, for clients that connect between two frames.
    newest: Option<Arc<str>>,
    has_ended: bool,
}

/// Opens the port of an address; port 0 chooses a free port.
///
/// # Errors
/// [`Failure::BadInput`] if the address is in use, not local to the machine, or not permitted.
pub fn bind(address: SocketAddr) -> Result<TcpListener, Failure> {
    TcpListener::bind(address).map_err(|error| {
        let reason = match error.kind() {
            ErrorKind::AddrInUse => "the port is in use; choose another one, or 0 for a free port".to_owned(),
            ErrorKind::AddrNotAvailable => "this machine does not have this address".to_owned(),
            _ => error.to_string(),
        };
        bad_input(format!("--serve {address}: {reason}"))
    })
}

impl Server {
    /// Starts the server and prints the address of the page, with a warning if other machines may reach it.
    ///
    /// # Errors
    /// [`Failure::NotComputed`] if no thread can be started.
    pub fn start<'a>(
        listener: TcpListener,
        fingers: impl Iterator<Item = (&'a str, &'a Finger)>,
    ) -> Result<Server, Failure> {
        let drawings: Vec<Drawing> = fingers.map(|(name, finger)| drawing(name, finger)).collect();
        // "<" is escaped, so that the text cannot end the script element that contains it.
        let fingers = serde_json::to_string(&drawings).map_err(not_computed)?.replace('<', "\\u003c");
        let address = listener.local_addr().map_err(not_computed)?;
        let [connections, clients] = [0, 0].map(AtomicUsize::new);
        let shared = Arc::new(Shared { address, fingers, events: Mutex::default(), connections, clients });
        let accepting = Arc::clone(&shared);
        thread::Builder::new().spawn(move || accept(&listener, &accepting)).map_err(not_computed)?;
        if !address.ip().is_loopback() {
            print_message(format_args!(
                "warning: --serve {address}: every machine that reaches this address can read the page, without password or encryption"
            ));
        }
        // Without the address, nobody can open the page, so `--quiet` does not omit it.
        print_line(format_args!("note: the page is at http://{address}/"));
        Ok(Server(shared))
    }

    /// Sends a line of JSON to all clients. The call does not wait: a client whose queue is full misses the line.
    pub fn send(&self, line: &str) {
        let event: Arc<str> = format!("data: {line}\n\n").into();
        let mut events = self.0.events();
        events.queues.retain(|queue| !matches!(queue.try_send(event.clone()), Err(TrySendError::Disconnected(_))));
        events.newest = Some(event);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        {
            let mut events = self.0.events();
            events.has_ended = true;
            events.queues.clear();
        }
        let until = Instant::now() + FAREWELL;
        while self.0.clients.load(Ordering::SeqCst) > 0 && Instant::now() < until {
            thread::sleep(Duration::from_millis(5));
        }
    }
}

fn drawing<'a>(name: &'a str, finger: &Finger) -> Drawing<'a> {
    let lines = finger.outline().into_iter();
    Drawing {
        name,
        lines: lines.map(|(_, points)| points.into_iter().map(|point| finger.point(point).into()).collect()).collect(),
        base: finger.plate_point(Plate::Front, 0.0).into(),
        along: finger.front_tangent().into(),
        inward: finger.inward(Plate::Front).into(),
    }
}

/// Counts something until it is dropped.
struct Counted<'a>(&'a AtomicUsize);

impl<'a> Counted<'a> {
    /// `None` if the count would exceed `largest`.
    fn up_to(largest: usize, count: &'a AtomicUsize) -> Option<Counted<'a>> {
        let counted = Counted(count);
        (count.fetch_add(1, Ordering::SeqCst) < largest).then_some(counted)
    }
}

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    for stream in listener.incoming() {
        let Ok(stream) = stream else {
            // A connection cannot be accepted, for example because the process has too many open files.
            thread::sleep(Duration::from_millis(100));
            continue;
        };
        let shared = Arc::clone(shared);
        // If no thread can be started, or too many connections exist, the stream is dropped, which closes it. A client that disconnects is not an
        // error.
        let _ = thread::Builder::new().spawn(move || {
            if let Some(_connection) = Counted::up_to(LARGEST_CONNECTIONS, &shared.connections) {
                let _ = shared.answer(stream);
            }
        });
    }
}

impl Shared {
    // A panic of another thread poisons the lock, but does not make the queues invalid.
    fn events(&self) -> MutexGuard<'_, Events> {
        self.events.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn answer(&self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_write_timeout(Some(WRITE_LIMIT))?;
        stream.set_nodelay(true)?;
        let request = read_request(&mut stream)?;
        match self.status_of(request.as_deref()) {
            Ok("/") => {
                let nonce = format!("{:016x}{:016x}", RandomState::new().hash_one(0), RandomState::new().hash_one(1));
                let page = PAGE.replace("NONCE", &nonce).replace("FINGERS", &self.fingers);
                let policy = format!(
                    "Content-Security-Policy: default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; \
                     connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n"
                );
                respond(&mut stream, "200 OK", "text/html", &policy, &page)
            }
            Ok(_) => match Counted::up_to(LARGEST_CLIENTS, &self.clients) {
                Some(_client) => self.stream_events(stream),
                None => respond(&mut stream, "503 Service Unavailable", "text/plain", "", "too many clients\n"),
            },
            Err(status) => {
                let allow = if status.starts_with("405") { "Allow: GET\r\n" } else { "" };
                respond(&mut stream, status, "text/plain", allow, &format!("{status}\n"))
            }
        }
    }

    /// Path of a request (`/` or `/events`), or the HTTP status with which the request is refused.
    fn status_of<'r>(&self, request: Option<&'r str>) -> Result<&'r str, &'static str> {
        const BAD: &str = "400 Bad Request";
        let mut lines = request.ok_or(BAD)?.lines();
        let words: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
        let [method, path, "HTTP/1.1" | "HTTP/1.0"] = words[..] else { return Err(BAD) };
        let headers = lines.filter_map(|line| line.split_once(':'));
        let mut hosts = headers.filter(|(name, _)| name.eq_ignore_ascii_case("host")).map(|(_, host)| host.trim());
        match (hosts.next(), hosts.next()) {
            (Some(host), None) if self.is_own(host) => {}
            _ => return Err("403 Forbidden"),
        }
        match (method, path) {
            ("GET", "/" | "/events") => Ok(path),
            ("GET", _) => Err("404 Not Found"),
            _ => Err("405 Method Not Allowed"),
        }
    }

    /// Whether a request names this machine as its host. On a loopback address, a name that a foreign site resolved to this machine (DNS rebinding)
    /// is refused. On other addresses, every host name is accepted, because the machine's names are unknown.
    fn is_own(&self, host: &str) -> bool {
        let (own, port) = (self.address.to_string(), self.address.port());
        let is = |name: &str| host.eq_ignore_ascii_case(&format!("{name}:{port}")) || (port == 80 && host == name);
        !self.address.ip().is_loopback() || host == own || ["localhost", "127.0.0.1", "[::1]"].into_iter().any(is)
    }

    /// Sends events until the stream ends or the client leaves.
    fn stream_events(&self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.write_all(head("200 OK", "text/event-stream", "").as_bytes())?;
        let events = self.subscribe();
        loop {
            match events.recv_timeout(HEARTBEAT) {
                Ok(event) => stream.write_all(event.as_bytes())?,
                Err(RecvTimeoutError::Timeout) => stream.write_all(b":\n\n")?,
                Err(RecvTimeoutError::Disconnected) => return stream.write_all(b"event: end\ndata: end\n\n"),
            }
        }
    }

    /// A queue of the newest and all later events.
    fn subscribe(&self) -> Receiver<Arc<str>> {
        let (queue, receiver) = mpsc::sync_channel(QUEUE);
        let mut events = self.events();
        if let Some(newest) = &events.newest {
            // The queue is empty, so the event fits.
            let _ = queue.try_send(newest.clone());
        }
        if !events.has_ended {
            events.queues.push(queue);
        }
        receiver
    }
}

/// The head of a request as text; `None` if it is too long, too slow, cut off or not UTF-8.
fn read_request(stream: &mut TcpStream) -> std::io::Result<Option<String>> {
    let until = Instant::now() + REQUEST_LIMIT;
    let (mut bytes, mut part) = (Vec::new(), [0; 1024]);
    while !bytes.windows(4).any(|end| end == b"\r\n\r\n") {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() || bytes.len() > LARGEST_REQUEST {
            return Ok(None);
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut part) {
            Ok(0) => return Ok(None),
            Ok(length) => bytes.extend(&part[..length]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => return Ok(None),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(String::from_utf8(bytes).ok())
}

/// Status line and headers of a response, including the further headers in `headers`, each of which ends with a line break.
fn head(status: &str, kind: &str, headers: &str) -> String {
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\nConnection: close\r\n{headers}\r\n"
    )
}

fn respond(stream: &mut TcpStream, status: &str, kind: &str, headers: &str, body: &str) -> std::io::Result<()> {
    let head = head(status, kind, &format!("{headers}Content-Length: {}\r\n", body.len()));
    stream.write_all((head + body).as_bytes())
}
