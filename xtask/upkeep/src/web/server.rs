//! Serves a folder to the browsers of this machine: enough of HTTP for pages and their files, and no more.

use crate::cli::ServeOptions;
use anyhow::{Context as _, Result};
use std::{
    fs,
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::{Ipv4Addr, TcpListener, TcpStream},
    path::{Component, Path, PathBuf},
    time::Duration,
};

/// Longest request that is read.
const LONGEST_REQUEST: u64 = 64 << 10;

/// Takes the port that was asked for; none if nothing is to be served.
pub(crate) fn listener(options: &ServeOptions) -> Result<Option<TcpListener>> {
    if options.no_serve {
        return Ok(None);
    }
    listen(options.port).map(Some)
}

/// Takes a port of this machine.
fn listen(port: u16) -> Result<TcpListener> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(|| {
        format!("port {port} can't be taken: name another one by --port, or use --no-serve")
    })
}

/// Serves until the program is stopped.
pub(crate) fn serve(listener: &TcpListener, folder: &Path) -> Result<()> {
    println!(
        "serving at http://localhost:{}/ (Ctrl+C ends it)",
        listener.local_addr()?.port()
    );
    for stream in listener.incoming() {
        let folder = folder.to_owned();
        std::thread::spawn(move || {
            // Browsers close connections when they like to.
            if let Ok(stream) = stream {
                drop(answer(&stream, &folder));
            }
        });
    }
    Ok(())
}

fn answer(mut stream: &TcpStream, folder: &Path) -> std::io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(10)))?;
    let mut lines = BufReader::new(stream.take(LONGEST_REQUEST)).lines();
    let Some(first) = lines.next().transpose()? else {
        return Ok(());
    };
    // What is left unread would make the system reset the connection, and so lose the answer.
    for line in lines {
        if line?.is_empty() {
            break;
        }
    }
    let mut words = first.split(' ');
    let (method, target) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
    let found = match method {
        "GET" | "HEAD" => {
            file_of(folder, target).and_then(|file| Some((kind(&file), fs::read(&file).ok()?)))
        }
        _ => None,
    };
    let (status, (kind, body)) = match found {
        Some(found) => ("200 OK", found),
        None => (
            "404 Not Found",
            ("text/plain", b"There is no such file.\n".to_vec()),
        ),
    };
    // Else a browser shows what was built before.
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    if method != "HEAD" {
        stream.write_all(&body)?;
    }
    stream.flush()
}

/// Returns the file that a request's target means, of a folder its `index.html`; none if it leaves the folder.
fn file_of(folder: &Path, target: &str) -> Option<PathBuf> {
    let path = target.split(['?', '#']).next()?.strip_prefix('/')?;
    let stays = Path::new(path)
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    let file = match path.is_empty() || path.ends_with('/') {
        true => folder.join(path).join("index.html"),
        false => folder.join(path),
    };
    stays.then_some(file)
}

/// Returns the kind of a file as browsers want it told: they compile no module of another kind.
fn kind(file: &Path) -> &'static str {
    match file.extension().and_then(|ending| ending.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("png") => "image/png",
        Some("svg") => "image/svg+xml",
        Some("css") => "text/css; charset=utf-8",
        Some("json") => "application/json",
        Some("woff2") => "font/woff2",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_served_and_others_are_not() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("page")).expect("made");
        fs::write(folder.path().join("secret"), "no").expect("written");
        fs::write(folder.path().join("page/index.html"), "<p>yes").expect("written");
        fs::write(folder.path().join("page/a.wasm"), "module").expect("written");
        fs::create_dir(folder.path().join("page/inner")).expect("made");
        fs::write(folder.path().join("page/inner/index.html"), "<p>inside").expect("written");
        let listener = listen(0).expect("a port");
        let port = listener.local_addr().expect("an address").port();
        let page = folder.path().join("page");
        std::thread::spawn(move || serve(&listener, &page));
        let ask = |request: &str| {
            let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).expect("connected");
            write!(stream, "{request} HTTP/1.1\r\nHost: localhost\r\n\r\n").expect("sent");
            let mut out = String::new();
            stream.read_to_string(&mut out).expect("answered");
            out
        };
        let page = ask("GET /?scene=cubes");
        assert!(
            page.starts_with("HTTP/1.1 200") && page.ends_with("<p>yes"),
            "{page}"
        );
        let module = ask("GET /a.wasm");
        assert!(
            module.contains("application/wasm") && module.ends_with("module"),
            "{module}"
        );
        let inner = ask("GET /inner/?scene=cubes");
        assert!(inner.ends_with("<p>inside"), "{inner}");
        let head = ask("HEAD /a.wasm");
        assert!(
            head.contains("Content-Length: 6") && !head.contains("module"),
            "{head}"
        );
        for request in [
            "GET /b",
            "GET /../secret",
            "GET //etc/passwd",
            "POST /",
            "",
            "GET /%2e%2e/secret",
        ] {
            let refused = ask(request);
            assert!(refused.starts_with("HTTP/1.1 404"), "{request}: {refused}");
        }
    }
}
