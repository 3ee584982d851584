//! Serves a folder to the browsers of this machine, by the server that comes with Python.

use crate::{cli::ServeOptions, run::run};
use anyhow::{Context as _, Result};
use std::{
    net::{Ipv4Addr, TcpListener},
    path::Path,
    process::Command,
};

/// Python's server, which tells browsers to load what was built last.
const SERVER: &str = "
import sys
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
class Handler(SimpleHTTPRequestHandler):
    def __init__(self, *args):
        super().__init__(*args, directory=sys.argv[2])
    def end_headers(self):
        self.send_header('Cache-Control', 'no-store')
        super().end_headers()
    def log_message(self, *_):
        pass
try:
    ThreadingHTTPServer(('127.0.0.1', int(sys.argv[1])), Handler).serve_forever()
except KeyboardInterrupt:
    pass
";

/// A port of this machine, kept until the folder is served.
#[derive(Debug)]
pub(crate) struct Port(TcpListener);

impl Port {
    /// Takes the requested port, or a free one for 0; `None` if nothing is to be served.
    pub(crate) fn of(options: &ServeOptions) -> Result<Option<Self>> {
        if options.no_serve {
            return Ok(None);
        }
        let port = options.port;
        let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(|| {
            format!("port {port} can't be taken: name another one by --port, or use --no-serve")
        })?;
        Ok(Some(Self(taken)))
    }

    /// Serves until the program is stopped.
    pub(crate) fn serve(self, folder: &Path) -> Result<()> {
        let port = self.0.local_addr()?.port();
        // Python takes it over.
        drop(self.0);
        println!("serving at http://localhost:{port}/ (Ctrl+C ends it)");
        let help = "install python3, or serve the folder by another web server";
        run(&mut server(port, folder)).context(help)
    }
}

fn server(port: u16, folder: &Path) -> Command {
    let mut python = Command::new("python3");
    python.args(["-c", SERVER, &port.to_string()]).arg(folder);
    python
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{
        fs,
        io::{Read as _, Write as _},
        net::TcpStream,
        time::Duration,
    };

    #[test]
    fn files_are_served_and_others_are_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let page = folder.path().join("page");
        fs::create_dir_all(page.join("inner")).expect("made");
        fs::write(folder.path().join("secret"), "no").expect("written");
        fs::write(page.join("a.wasm"), "module").expect("written");
        fs::write(page.join("inner/index.html"), "<p>inside").expect("written");
        let options = ServeOptions {
            no_serve: false,
            port: 0,
        };
        let port = Port::of(&options).expect("a port").expect("to serve");
        let number = port.0.local_addr().expect("an address").port();
        let taken = Port::of(&ServeOptions {
            port: number,
            ..options
        })
        .expect_err("taken");
        assert!(taken.to_string().contains("--port"), "{taken}");
        drop(port);
        let mut python = server(number, &page).spawn().expect("python3 starts");
        let answer = |request: &str| {
            let connected = (0..200).find_map(|_| {
                std::thread::sleep(Duration::from_millis(50));
                TcpStream::connect((Ipv4Addr::LOCALHOST, number)).ok()
            });
            let mut stream = connected.expect("connected");
            write!(stream, "{request} HTTP/1.0\r\n\r\n").expect("sent");
            let mut out = String::new();
            stream.read_to_string(&mut out).expect("answered");
            out
        };
        let module = answer("GET /a.wasm");
        let inner = answer("GET /inner/?scene=cubes");
        let refused = ["/b", "/../secret", "//etc/passwd", "/%2e%2e/secret"]
            .map(|target| answer(&format!("GET {target}")));
        python.kill().expect("it ran");
        python.wait().expect("it ended");
        assert!(
            module.contains("application/wasm") && module.contains("no-store"),
            "{module}"
        );
        assert!(module.ends_with("module"), "{module}");
        assert!(inner.ends_with("<p>inside"), "{inner}");
        for refused in refused {
            assert!(refused.contains(" 404 "), "{refused}");
        }
    }
}
