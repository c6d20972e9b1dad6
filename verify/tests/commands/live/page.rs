//! The page that `--serve` shows.

use super::*;

/// A run of `live` that serves a page, and the page's port.
struct Served {
    child: std::process::Child,
    err: BufReader<std::process::ChildStderr>,
    port: u16,
}

/// Starts `live` on a free port. `more` are further arguments.
fn served(more: &[&str]) -> Served {
    let arguments = [&["live", CAMERA, "--contact-at", "auto@0", "--serve", "127.0.0.1:0"], more].concat();
    let mut command = command(&arguments);
    command.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().expect("finray starts");
    let mut err = BufReader::new(child.stderr.take().expect("standard error"));
    let mut note = String::new();
    err.read_line(&mut note).expect("a note");
    let port = note.strip_prefix("note: the page is at http://127.0.0.1:").and_then(|rest| rest.strip_suffix("/\n"));
    let port = port.and_then(|port| port.parse().ok()).unwrap_or_else(|| panic!("{note:?}"));
    Served { child, err, port }
}

/// Sends a request to the page.
fn requested(port: u16, request: &str) -> std::net::TcpStream {
    let mut stream = std::net::TcpStream::connect(("127.0.0.1", port)).expect("a connection");
    stream.set_read_timeout(Some(std::time::Duration::from_secs(20))).expect("a limit");
    std::io::Write::write_all(&mut stream, request.as_bytes()).expect("a request");
    stream
}

/// The whole answer to a request for a path.
fn fetched(port: u16, method: &str, path: &str, host: &str) -> String {
    let mut answer = String::new();
    let mut stream = requested(port, &format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    std::io::Read::read_to_string(&mut stream, &mut answer).expect("an answer");
    answer
}

/// The page draws the finger; each event contains a printed line; the last event states the end of the stream. Other requests are refused.
#[test]
fn a_page_shows_each_line() {
    let Served { mut child, mut err, port } = served(&[]);
    let own = format!("127.0.0.1:{port}");
    let page = fetched(port, "GET", "/", &own);
    assert_says(&page, &["HTTP/1.1 200 OK\r\n", "Content-Security-Policy: default-src 'none';", "\"inward\":["]);
    assert!(!page.contains("NONCE") && !page.contains("FINGERS") && !page.contains("https:"), "{page:.2000}");
    for (method, path, host, status) in [
        ("GET", "/", format!("localhost:{port}"), "200 "),
        ("GET", "/", format!("[::1]:{port}"), "200 "),
        ("GET", "/etc/passwd", own.clone(), "404 "),
        ("GET", "//events", own.clone(), "404 "),
        ("POST", "/", own.clone(), "405 "),
        ("GET", "/", format!("finger.example:{port}"), "403 "),
        ("GET", "/events", "localhost".to_owned(), "403 "),
        ("GET  ", "/", own.clone(), "400 "),
    ] {
        let answer = fetched(port, method, path, &host);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{method} {path} {host}: {answer:.300}");
    }
    let long = format!("GET / HTTP/1.1\r\nHost: {own}\r\nX: {}", "x".repeat(9000));
    let mut answer = String::new();
    // The connection may be reset, because the rest of the request is not read.
    let _ = std::io::Read::read_to_string(&mut requested(port, &long), &mut answer);
    assert!(!answer.contains("200 OK"), "{answer:.300}");

    let mut events = BufReader::new(requested(port, &format!("GET /events HTTP/1.1\r\nHost: {own}\r\n\r\n")));
    let mut text = String::new();
    while text != "\r\n" {
        text.clear();
        events.read_line(&mut text).expect("a header");
    }
    let mut input = child.stdin.take().expect("an input");
    let mut out = BufReader::new(child.stdout.take().expect("an output"));
    let mut next = |text: &mut String| {
        text.clear();
        // Comments and empty lines separate events.
        while text.trim().is_empty() || text.starts_with(':') {
            text.clear();
            assert!(events.read_line(text).expect("an event") > 0, "the connection is closed");
        }
    };
    // A client that is registered after the first line was printed also gets this line.
    for _ in 0..3 {
        std::io::Write::write_all(&mut input, pressed_frame().as_bytes()).expect("a frame");
        let mut line = String::new();
        out.read_line(&mut line).expect("a line");
        next(&mut text);
        assert_eq!(text, format!("data: {line}"));
    }
    drop(input);
    next(&mut text);
    assert_eq!(text, "event: end\n");
    assert_eq!(child.wait().expect("the end").code(), Some(0));
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut err, &mut rest).expect("text");
    assert!(rest.starts_with("done: 3 frames: 3 in contact"), "{rest}");
}

/// Clients that never read, or never finish their request, do not delay the frames.
#[test]
fn a_slow_client_does_not_stop_the_stream() {
    let Served { mut child, mut err, port } = served(&["--every-frame"]);
    let events = format!("GET /events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n");
    let clients: Vec<_> = (0..14).map(|_| requested(port, &events)).chain([requested(port, "GET / HT")]).collect();
    // All lines together exceed the buffers of the sockets: the line of a refused frame has about 300 bytes.
    let frames = 40_000;
    let mut input = child.stdin.take().expect("an input");
    let writing = std::thread::spawn(move || {
        let frame = format!("{{\"markers\":\"{}\"}}\n", "x".repeat(300));
        std::io::Write::write_all(&mut input, frame.repeat(frames).as_bytes()).expect("frames");
    });
    let began = std::time::Instant::now();
    let lines = BufReader::new(child.stdout.take().expect("an output")).lines().count();
    assert_eq!(lines, frames);
    // A write to a client that does not read would end only after 10 s.
    assert!(began.elapsed().as_secs() < 8, "{:?}", began.elapsed());
    writing.join().expect("all frames are written");
    assert_eq!(child.wait().expect("the end").code(), Some(0));
    drop(clients);
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut err, &mut rest).expect("text");
    assert_says(&rest, &["done: 40000 frames", "40000 refused"]);
}

/// An address that cannot be opened is refused before the scene is read. Other machines can reach the page only if `--serve` states such an address,
/// and a warning is printed.
#[test]
fn addresses_of_the_page_are_checked() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let taken = taken.local_addr().map(|address| (taken, address.to_string())).expect("an address");
    let serve =
        |address: &str| finray(&["live", "missing.toml", "--contact-at", "auto@0", "--serve", address]).refused();
    assert_says(&serve(&taken.1), &["--serve", &taken.1, "in use"]);
    assert_says(&serve("192.0.2.1:0"), &["192.0.2.1:0", "does not have this address"]);
    assert_says(&serve("8080"), &["--serve", "127.0.0.1:8080"]);
    let answer =
        finray_reading(pressed_frame().as_bytes(), &["live", CAMERA, "--contact-at", "auto@0", "--serve", "0.0.0.0:0"]);
    assert_eq!(answer.code, Some(0));
    assert_says(
        &answer.err,
        &["warning: --serve 0.0.0.0:", "without password", "note: the page is at http://0.0.0.0:"],
    );
}
