"""People who sign content credentials: certificates and keys made for a test, and their reader."""

import datetime
import io
import json
from pathlib import Path

import pytest

c2pa = pytest.importorskip("c2pa", reason="pip install -e '.[credentials]'")
from cryptography import x509  # noqa: E402
from cryptography.hazmat.primitives import hashes, serialization  # noqa: E402
from cryptography.hazmat.primitives.asymmetric import dsa, ec, ed25519, rsa  # noqa: E402, F401
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID  # noqa: E402

MAIL = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.EMAIL_PROTECTION])
KIND = "http://cv.iptc.org/newscodes/digitalsourcetype/"
TODAY = datetime.datetime.now(datetime.UTC)
TYPES = {
    ".jpg": "image/jpeg",
    ".png": "image/png",
    ".tif": "image/tiff",
    ".webp": "image/webp",
    ".heic": "image/heic",
    ".dng": "image/x-adobe-dng",
}


def pem(one):
    return one.public_bytes(serialization.Encoding.PEM)


def key_pem(key, password=None):
    way = serialization.NoEncryption()
    if password is not None:
        way = serialization.BestAvailableEncryption(password)
    form = serialization.PrivateFormat.PKCS8
    return key.private_bytes(serialization.Encoding.PEM, form, way)


def _certificate(subject, issuer, key, by, *, is_root, days):
    def named(name):
        return x509.Name(
            [
                x509.NameAttribute(NameOID.ORGANIZATION_NAME, "Kogao's tests"),
                x509.NameAttribute(NameOID.COMMON_NAME, name),
            ]
        )

    uses = dict.fromkeys(
        ("content_commitment", "key_encipherment", "data_encipherment", "key_agreement"), False
    )
    uses |= {"encipher_only": False, "decipher_only": False, "crl_sign": is_root}
    uses |= {"key_cert_sign": is_root, "digital_signature": not is_root}
    made = (
        x509.CertificateBuilder(named(issuer), named(subject), key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(TODAY + datetime.timedelta(days=min(days) - 0.1))
        .not_valid_after(TODAY + datetime.timedelta(days=max(days) + 0.1))
        .add_extension(x509.BasicConstraints(is_root, None), True)
        .add_extension(x509.KeyUsage(**uses), True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(by.public_key()), False)
    )
    return (made if is_root else made.add_extension(MAIL, False)).sign(by, hashes.SHA256())


def self_signed(key):
    return pem(_certificate("me", "me", key, key, is_root=True, days=(-1, 9)))


class Person:
    """Somebody with a key, a certificate, and a root that vouches for it."""

    def __init__(self, folder, key=None, days=(-1, 9)):
        folder.mkdir(exist_ok=True)
        self.key = key or ec.generate_private_key(ec.SECP256R1())
        theirs = ec.generate_private_key(ec.SECP256R1())
        root = _certificate("root", "root", theirs, theirs, is_root=True, days=(-99, 99))
        mine = _certificate("Photographer", "root", self.key, theirs, is_root=False, days=days)
        self.root = pem(root).decode()
        self.certificate, self.key_file = str(folder / "chain.pem"), str(folder / "key.pem")
        (folder / "chain.pem").write_bytes(pem(mine) + pem(root))
        (folder / "key.pem").write_bytes(key_pem(self.key))

    def told(self, path):
        """Return what C2PA's own reader says of a file, its signature checked by our root."""
        trust = {"user_anchors": self.root}
        checks = {"verify_trust": True, "remote_manifest_fetch": False}
        context = c2pa.Context.from_dict({"trust": trust, "verify": checks})
        with c2pa.Reader(TYPES[path.suffix], io.BytesIO(path.read_bytes()), context=context) as it:
            return it.get_validation_state(), it.get_active_manifest(), json.loads(it.json())

    def sign(self, path):
        """Sign a file as a camera would, with C2PA's own tool."""
        created = {"action": "c2pa.created", "digitalSourceType": f"{KIND}digitalCapture"}
        manifest = {"assertions": [{"label": "c2pa.actions.v2", "data": {"actions": [created]}}]}
        chain = Path(self.certificate).read_bytes()
        info = c2pa.C2paSignerInfo("es256", chain, key_pem(self.key), None)
        out = io.BytesIO()
        with c2pa.Builder(manifest) as builder, c2pa.Signer.from_info(info) as hand:
            builder.sign(hand, TYPES[path.suffix], io.BytesIO(path.read_bytes()), out)
        path.write_bytes(out.getvalue())
