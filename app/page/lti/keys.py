"""Hold the lab's own key: sign for platforms, seal what a browser keeps, and give the public key set."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from typing import Any

import jwt
from cryptography.fernet import Fernet, InvalidToken
from cryptography.hazmat.primitives.asymmetric.rsa import RSAPrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, PublicFormat, load_pem_private_key
from jwt.algorithms import RSAAlgorithm

from ...course.handin.keys import derive_key

ALGORITHM = "RS256"  # the one that the security framework asks of all
MIN_KEY_BITS = 2048
SALT = b"observer-lab lti keys 1"


class ToolKeys:
    """The private key of the lab and what follows from it. No text shows any of it."""

    def __init__(self, pem: str) -> None:
        """Raises ValueError at what is no RSA key of 2048 bits or more."""
        try:
            key = load_pem_private_key(pem.encode(), None)
        except (ValueError, TypeError) as problem:  # TypeError: it asks for a passphrase
            raise ValueError("it holds no private key in PEM without a passphrase") from problem
        if not isinstance(key, RSAPrivateKey) or key.key_size < MIN_KEY_BITS:
            raise ValueError(f"it holds no RSA key of {MIN_KEY_BITS} bits or more")
        self._key = key
        public = key.public_key()
        self._id = hashlib.sha256(public.public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo)).hexdigest()[:16]
        secret = key.private_bytes(Encoding.DER, PrivateFormat.PKCS8, NoEncryption())
        self._box = Fernet(base64.urlsafe_b64encode(derive_key(secret, SALT, b"what a browser keeps")))
        self.key_set = {"keys": [{**RSAAlgorithm.to_jwk(public, as_dict=True), "kid": self._id, "alg": ALGORITHM, "use": "sig"}]}

    def sign(self, claims: Mapping[str, Any]) -> str:
        """A token with these claims."""
        return jwt.encode(dict(claims), self._key, algorithm=ALGORITHM, headers={"kid": self._id})

    def seal(self, content: Mapping[str, Any]) -> str:
        """Content that only this lab can read, with the time of sealing."""
        return self._box.encrypt(json.dumps(content, separators=(",", ":")).encode()).decode()

    def opened(self, sealed: str, seconds: int) -> dict[str, Any] | None:
        """What was sealed no longer ago than that, None otherwise."""
        try:
            data = json.loads(self._box.decrypt(sealed.encode(), ttl=seconds))
        except (InvalidToken, ValueError):
            return None
        return data if isinstance(data, dict) else None

    def sealed_at(self, sealed: str) -> int:
        """When it was sealed, in seconds since 1970; 0 for what this lab has not sealed."""
        try:
            return self._box.extract_timestamp(sealed.encode())
        except (InvalidToken, ValueError):
            return 0
