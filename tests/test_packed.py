"""A picture is packed once, however many tabs show it, and another one is never taken for it."""

from __future__ import annotations

import numpy as np

from observer_lab.page.viser_private import packed_images
from observer_lab.page.viser_private.packed_images import pack_cached


def packs(asked: list[bytes]):
    def pack(image: np.ndarray, kind: str, quality: int | None = None) -> tuple[str, bytes]:
        asked.append(image.tobytes())
        return kind, bytes([len(asked)])
    return pack_cached(pack)


def test_the_same_picture_is_packed_once_and_any_other_anew() -> None:
    asked: list[bytes] = []
    pack = packs(asked)
    image = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
    first = pack(image, "png")
    assert pack(image.copy(), "png") == first and pack(np.asfortranarray(image), "png") == first and len(asked) == 1
    others = [(image + 1, ["png"], {}), (image.reshape(5, 4, 3), ["png"], {}), (image.view(np.int8), ["png"], {}), (image, ["jpeg"], {}),
              (image, ["png"], {"quality": 80})]
    for count, (other, how, said) in enumerate(others, start=2):
        assert pack(other, *how, **said) != first and len(asked) == count
    image[0, 0, 0] = 9  # one that is painted over is another
    pack(image, "png")
    assert len(asked) == len(others) + 2


def test_the_latest_pictures_are_kept_and_no_more(monkeypatch) -> None:
    monkeypatch.setattr(packed_images, "MAX_CACHED_PICTURES", 3)
    asked: list[bytes] = []
    pack = packs(asked)
    for shade in (0, 1, 2, 0, 3, 0, 1):  # 1 has gone when 3 came: 0 was asked for since
        pack(np.full((2, 2, 3), shade, dtype=np.uint8), "png")
    assert [said[0] for said in asked] == [0, 1, 2, 3, 1]
