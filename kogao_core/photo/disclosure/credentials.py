"""Content credentials (C2PA) of a result, signed by the user, with the photo as their source."""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Final

import kogao_core
from kogao_core.base.atomic import Pieces
from kogao_core.base.installed import adding
from kogao_core.base.language import Text
from kogao_core.base.wording import system_reason
from kogao_core.photo import formats
from kogao_core.photo.errors import CannotDisclose, MissingExtra
from kogao_core.photo.metadata import tiff
from kogao_core.photo.model import Photo

if TYPE_CHECKING:
    from cryptography.x509 import Certificate

PASSWORD: Final = "KOGAO_SIGN_PASSWORD"
"""Name of the environment variable that holds a key's password."""
_EDITED: Final = "http://cv.iptc.org/newscodes/digitalsourcetype/humanEdits"
# C2PA's algorithms by the kind of a key, as certificates name it, and its bits; 0 are any.
_ALGORITHMS: Final = {
    **{
        ("1.2.840.10045.2.1", bits): name
        for bits, name in ((256, "es256"), (384, "es384"), (521, "es512"))
    },
    ("1.3.101.112", 0): "ed25519",
    ("1.2.840.113549.1.1.1", 0): "ps256",
    ("1.2.840.113549.1.1.10", 0): "ps256",
}
_PROGRAM: Final = {"name": "Kogao", "version": kogao_core.__version__}
_BUILDER: Final = {
    "thumbnail": {"enabled": False},
    "intent": "edit",
    "claim_generator_info": _PROGRAM,
}
_LOCAL: Final = {"remote_manifest_fetch": False, "ocsp_fetch": False, "verify_trust": False}


@dataclass(frozen=True, slots=True)
class Signer:
    """Who signs."""

    certificate: str  # a PEM file: the signer's certificate first, then those that vouch for it
    key: str  # a PEM file with its private key; a protected one's password is in `PASSWORD`


def check_signer(signer: Signer) -> None:
    """Check that there is what it takes to sign. Raises MissingExtra, CannotDisclose."""
    _c2pa()
    _read(signer)


def signed(photo: Photo, pieces: Pieces, form: str, *, signer: Signer, what: str) -> Pieces:
    """Return a file with credentials that say what was done to a photo; no pixel changes.

    The photo's file is their source, with the credentials that it has itself. Nothing is fetched
    from anywhere, and no thumbnail is made: it would show the face as it was. Raises
    CannotDisclose.
    """
    if not photo.is_as_read:
        raise CannotDisclose(
            Text("{path} has changed since it was read; open it again", path=photo.path)
        )
    c2pa = _c2pa()
    algorithm, chain, key = _read(signer)
    source = photo.path.read_bytes()
    # Without credentials of its own nothing else would tell which file it was.
    digest = hashlib.sha256(source).hexdigest()
    whole = {"relationship": "parentOf", "description": f"SHA-256 {digest}"}
    result = io.BytesIO()
    try:
        context = c2pa.Context.from_dict({"verify": _LOCAL, "builder": _BUILDER})
        info = c2pa.C2paSignerInfo(algorithm, chain, key, None)
        with c2pa.Builder(_manifest(what), context=context) as builder:
            builder.add_ingredient(whole, _type(photo, source), io.BytesIO(source))
            with c2pa.Signer.from_info(info) as hand:
                builder.sign(hand, formats.BY_NAME[form].mime, io.BytesIO(b"".join(pieces)), result)
    except c2pa.C2paError as error:
        said = str(error).split(": ", 1)[-1]  # C2PA's own words: it names their kind twice
        raise CannotDisclose(
            Text("the result can't be signed ({problem}); save it without", problem=said)
        ) from error
    return [result.getvalue()]


def _c2pa() -> ModuleType:
    try:
        import c2pa  # an extra
    except ImportError:
        raise MissingExtra(
            Text("signing needs an extra: {how}", how=adding("credentials"))
        ) from None
    module: ModuleType = c2pa
    return module


def _manifest(what: str) -> dict[str, Any]:
    action = {
        "action": "c2pa.edited",
        "description": what,
        "when": datetime.now(UTC).isoformat(timespec="seconds"),
        "softwareAgent": _PROGRAM,
        "digitalSourceType": _EDITED,
    }
    return {"assertions": [{"label": "c2pa.actions.v2", "data": {"actions": [action]}}]}


def _type(photo: Photo, source: bytes) -> str:
    """Return the type of a photo's file; raw files of many kinds are TIFF files."""
    is_tiff = photo.format == "RAW" and source.startswith(tiff.HEADS)
    return formats.BY_NAME["TIFF" if is_tiff else photo.format].mime


def _read(signer: Signer) -> tuple[str, bytes, bytes]:
    """Return the algorithm, the certificates and the plain key, as PEM."""
    from cryptography import x509  # comes with the extra
    from cryptography.hazmat.primitives import serialization

    chain = _bytes_of(signer.certificate)
    key = _key(signer, serialization.load_pem_private_key)
    try:
        certificate = x509.load_pem_x509_certificates(chain)[0]
    except ValueError:
        raise CannotDisclose(
            Text("{path} holds no certificate; name a PEM file", path=signer.certificate)
        ) from None
    _check_pair(signer, certificate, key)
    plain = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    kind = certificate.public_key_algorithm_oid.dotted_string
    bits = getattr(key, "key_size", 0)
    algorithm = _ALGORITHMS.get((kind, bits)) or _ALGORITHMS.get((kind, 0))
    if algorithm is None:
        raise CannotDisclose(
            Text("the key {path} is of a kind that C2PA doesn't know; use P-256", path=signer.key)
        )
    return algorithm, chain, plain


def _key(signer: Signer, load: Callable[[bytes, bytes | None], Any]) -> Any:
    data, password = _bytes_of(signer.key), os.environ.get(PASSWORD)
    try:
        try:
            return load(data, None)
        except TypeError:  # it is protected
            if not password:
                raise CannotDisclose(
                    Text(
                        "the key {path} is protected by a password; put it into the environment "
                        "variable {name}",
                        path=signer.key,
                        name=PASSWORD,
                    )
                ) from None
            return load(data, password.encode())
    except ValueError:
        raise CannotDisclose(
            Text(
                "{path} holds no private key, or its password is another; name a PEM file",
                path=signer.key,
            )
        ) from None


def _check_pair(signer: Signer, certificate: Certificate, key: Any) -> None:
    if certificate.public_key() != key.public_key():
        raise CannotDisclose(
            Text(
                "the key {key} isn't that of the first certificate in {path}; name the key's own",
                key=signer.key,
                path=signer.certificate,
            )
        )
    if not certificate.not_valid_before_utc <= datetime.now(UTC) <= certificate.not_valid_after_utc:
        raise CannotDisclose(
            Text(
                "the certificate {path} is valid from {start} to {end} only; ask for a new one",
                path=signer.certificate,
                start=certificate.not_valid_before_utc.date(),
                end=certificate.not_valid_after_utc.date(),
            )
        )


def _bytes_of(name: str) -> bytes:
    try:
        return Path(name).read_bytes()
    except OSError as error:
        raise CannotDisclose(
            Text("{path} can't be read ({problem})", path=name, problem=system_reason(error))
        ) from error
