"""A local web server that behaves well or badly, for tests of downloads."""
import http.server
import re
import threading


class FileServer:
    """Serves `files` (path to bytes) at `url`; `requests` lists (path, Range header) of each request."""

    def __init__(self, files, ranges=True, etag='"1"', cut_after=None, content_type="application/zip"):
        self.files, self.ranges, self.etag, self.content_type = files, ranges, etag, content_type
        self.cut_after = cut_after  # [bytes] of an answer after which the connection ends; None: never
        self.requests = []
        server = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                server.answer(self)

            def log_message(self, *_):
                pass

        self.http = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.thread = threading.Thread(target=self.http.serve_forever, args=(0.01,))
        self.thread.start()

    @property
    def url(self):
        return f"http://127.0.0.1:{self.http.server_port}"

    def close(self):
        self.http.shutdown()
        self.thread.join()
        self.http.server_close()

    def answer(self, request):
        asked = request.headers.get("Range")
        self.requests.append((request.path, asked))
        whole = self.files.get(request.path)
        if whole is None:
            request.send_error(404)
            return
        start = int(re.fullmatch(r"bytes=(\d+)-", asked)[1]) if asked and self.ranges else 0
        if request.headers.get("If-Range", self.etag) != self.etag:
            start = 0
        if start >= len(whole) > 0:
            request.send_response(416)
            request.send_header("Content-Range", f"bytes */{len(whole)}")
            request.send_header("Content-Length", "0")
            request.end_headers()
            return
        request.send_response(206 if start else 200)
        if start:
            request.send_header("Content-Range", f"bytes {start}-{len(whole) - 1}/{len(whole)}")
        request.send_header("Content-Length", str(len(whole) - start))
        request.send_header("Content-Type", self.content_type)
        if self.etag:
            request.send_header("ETag", self.etag)
        request.end_headers()
        end = len(whole) if self.cut_after is None else start + self.cut_after
        request.wfile.write(whole[start:end])
        request.close_connection = True
