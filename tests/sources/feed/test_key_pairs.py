"""A key pair: nobody else can read what crosses the network, nor gets in without the key."""

import stat
import time
from contextlib import closing

import attrs
import pytest
from serving import Serving

from hmdwarp.errors import InputError
from hmdwarp.run import LiveOptions, live
from hmdwarp.sources.feed import FeedOptions
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import encode
from hmdwarp.sources.feed.options import key_pair, public_key

from .exchange import exchanged, port_of
from .messages import ASK, FRAME
from .relay import Relay

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")


@pytest.fixture
def pair(tmp_path):
    made, is_new = key_pair(tmp_path / "mine")
    assert is_new
    return made


def test_a_pair_is_made_once_and_its_secret_is_this_users_alone(pair, tmp_path):
    again, is_new = key_pair(tmp_path / "mine")
    assert again == pair and not is_new
    assert public_key(tmp_path / "mine.key") == pair.public
    assert stat.S_IMODE((tmp_path / "mine.key_secret").stat().st_mode) == 0o600
    assert pair.secret not in (tmp_path / "mine.key").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.key", "mine.key_secret"]


@pytest.mark.parametrize("text", ["", 'curve\n    public-key = "short"\n', "\x00\xff"])
def test_files_without_keys_are_named(tmp_path, text):
    bad = tmp_path / "bad.key"
    bad.write_text(text)
    (tmp_path / "bad.key_secret").write_text(text)
    for read in (lambda: public_key(bad), lambda: key_pair(tmp_path / "bad"), lambda: public_key(tmp_path)):
        with pytest.raises(InputError, match="hmdwarp serve --key-pair"):
            read()


@pytest.mark.parametrize("encrypted", [True, False])
def test_network_traffic_is_plain_only_without_keys(pair, encrypted):
    used = pair if encrypted else None
    server_key = used.public if used else b""
    with closing(Listener("127.0.0.1:*", pair=used)) as listener, Relay(port_of(listener.address)) as relay:
        relay.seen = bytearray()
        with closing(Caller(relay.address, server_key=server_key)) as caller:
            # A request and a frame, both ways.
            arrival, _ = exchanged(caller, listener)
    assert arrival.frame.colours[0].tobytes() == FRAME.colours[0].tobytes()
    pictures, magic = FRAME.colours[0].tobytes(), encode(ASK)[:4]
    plain = pictures in relay.seen and magic in relay.seen
    assert relay.seen and plain != encrypted
    if encrypted:
        assert pictures not in relay.seen and magic not in relay.seen and pair.public not in relay.seen


@pytest.mark.parametrize("key", ["another server's", "none"])
def test_a_client_without_the_key_gets_no_frame_but_a_reason(pair, tmp_path, key):
    other = key_pair(tmp_path / "other")[0].public if key != "none" else b""
    lines: list[str] = []
    listener = Listener("127.0.0.1:*", pair=pair)
    with closing(listener), closing(Caller(listener.address, server_key=other)) as caller:
        while not lines:
            caller.ask(attrs.evolve(ASK, token=bytes(32)))
            assert listener.next(10) is None
            lines = caller.lines()
            time.sleep(0.01)
        assert caller.take() == []
    assert "no handshake" in lines[0] and "--server-key" in lines[0]


def test_serve_and_live_speak_encrypted(tmp_path):
    name = tmp_path / "mine"
    with Serving("--listen", "0.0.0.0:*", "--key-pair", str(name)) as one:
        there = "127.0.0.1:" + one.address.rpartition(":")[2]
        said = {"source": "offscreen", "trace": "look-around", "connect": there, "panel": False, "pictures": 3}
        done = live(LiveOptions.of({**said, "server_key": tmp_path / "mine.key", "size": "96x80"}))
        assert done.summary["live"]["refreshes"] == 3
        with pytest.raises(InputError, match="no handshake"):
            live(LiveOptions.of({**said, "size": "96x80"}))


def test_an_address_beyond_this_machine_needs_keys_a_secret_or_consent(pair):
    for allowed in ({"pair": pair}, {"secret": "secret"}, {"is_open": True}):
        Listener("0.0.0.0:*", **allowed).close()
    with pytest.raises(InputError, match="--key-pair NAME or --token-file FILE, or --open"):
        Listener("0.0.0.0:*")


@pytest.mark.parametrize("option", ["server_key", "token_file"])
def test_a_key_or_secret_without_a_server_is_refused(tmp_path, option):
    with pytest.raises(InputError, match="--connect"):
        FeedOptions(**{option: tmp_path})
