//! Serves a folder to the browsers of this machine with Python's server.

use anyhow::{Context as _, Result, bail};
use std::{
    io::{Read as _, Write as _},
    net::{Ipv4Addr, TcpListener, TcpStream},
    path::Path,
    process::{Child, Command},
    time::Duration,
};

/// Python's server, with a header that makes browsers load the latest build.
const SERVER: &str = "
import sys, time
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
class Handler(SimpleHTTPRequestHandler):
    def __init__(self, *args):
        super().__init__(*args, directory=sys.argv[2])
    def end_headers(self):
        self.send_header('Cache-Control', 'no-store')
        super().end_headers()
    def log_message(self, *_):
        pass
class Server(ThreadingHTTPServer):
    def handle_error(self, *_):
        pass  # Browsers close connections at any time.
for attempts_left in reversed(range(100)):
    try:
        server = Server(('127.0.0.1', int(sys.argv[1])), Handler)
        break
    except OSError:
        if attempts_left == 0:
            raise
        time.sleep(.02)  # The port may still be reserved: see `is_served`.
try:
    server.serve_forever()
except KeyboardInterrupt:
    pass
";

/// Reserves a port of this machine, or a free one for 0. Reserving before the build reports a port
/// in use at once.
pub(crate) fn take_port(port: u16) -> Result<TcpListener> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(|| {
        format!("port {port} is not available: pass another --port, or use --no-serve")
    })
}

/// Returns whether a server answers at a port. Connecting proves nothing: a process that another
/// thread starts holds a copy of the reserved port until it runs its program. Such connections are
/// reset then. Another program at the port may never answer, so there is a limit.
fn is_served(port: u16) -> bool {
    let Ok(mut stream) = TcpStream::connect((Ipv4Addr::LOCALHOST, port)) else {
        return false;
    };
    let limit = Some(Duration::from_secs(1));
    stream.set_read_timeout(limit).is_ok()
        && stream.write_all(b"HEAD / HTTP/1.0\r\n\r\n").is_ok()
        && stream.read_exact(&mut [0]).is_ok()
}

/// A running server, which ends when it is dropped.
pub(crate) struct Server {
    python: Child,
    /// Address of its folder.
    pub(crate) address: String,
}

impl Server {
    /// Serves a folder at a port, which Python takes over.
    pub(crate) fn start(port: TcpListener, folder: &Path) -> Result<Self> {
        let port_number = port.local_addr()?.port();
        drop(port);
        let mut command = Command::new("python3");
        command.args(["-c", SERVER, &port_number.to_string()]);
        let python = command
            .arg(folder)
            .spawn()
            .context("install python3, or serve the folder by another web server")?;
        let mut server = Self {
            python,
            address: format!("http://localhost:{port_number}/"),
        };
        while !is_served(port_number) {
            if let Some(status) = server.python.try_wait()? {
                bail!("python3 could not serve the folder: it ended with {status}");
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(server)
    }

    /// Serves until the program is stopped.
    pub(crate) fn run(mut self) -> Result<()> {
        println!("serving at {} (Ctrl+C to stop)", self.address);
        self.python.wait()?;
        Ok(())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.python.kill());
        drop(self.python.wait());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{fs, thread};

    #[test]
    fn files_are_served_and_others_are_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let page = folder.path().join("page");
        fs::create_dir_all(page.join("inner")).expect("made");
        fs::write(folder.path().join("secret"), "no").expect("written");
        fs::write(page.join("a.wasm"), "module").expect("written");
        fs::write(page.join("inner/index.html"), "<p>inside").expect("written");
        let port = take_port(0).expect("a port");
        let number = port.local_addr().expect("an address").port();
        let taken = take_port(number).expect_err("taken");
        assert!(taken.to_string().contains("--port"), "{taken}");
        // Hold the reserved port for a while, like a process that is being started.
        let held = port.try_clone().expect("a copy");
        thread::spawn(move || {
            thread::sleep(Duration::from_millis(500));
            drop(held);
        });
        let _server = Server::start(port, &page).expect("python3 starts");
        let get = |target: &str| {
            let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, number)).expect("connected");
            write!(stream, "GET {target} HTTP/1.0\r\n\r\n").expect("sent");
            let mut out = String::new();
            stream.read_to_string(&mut out).expect("answered");
            out
        };
        let module = get("/a.wasm");
        assert!(module.contains("application/wasm"), "{module}");
        assert!(module.contains("Cache-Control: no-store"), "{module}");
        assert!(module.ends_with("module"), "{module}");
        let inner = get("/inner/?scene=cubes");
        assert!(inner.ends_with("<p>inside"), "{inner}");
        for outside in ["/b", "/../secret", "//etc/passwd", "/%2e%2e/secret"] {
            let refused = get(outside);
            assert!(refused.contains(" 404 "), "{outside}: {refused}");
        }
    }

    #[test]
    fn a_port_that_another_program_keeps_is_an_error() {
        let port = take_port(0).expect("a port");
        // Connections are accepted, and nothing answers.
        let _kept = port.try_clone().expect("a copy");
        let error = Server::start(port, Path::new(".")).err().expect("is kept");
        assert!(error.to_string().contains("could not serve"), "{error}");
    }
}
