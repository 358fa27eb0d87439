"""The page of stored originals in the preferences."""

from kogao_app.widgets.originals import OriginalsPage

from kogao_core.photo.originals import Originals


def test_stored_originals_are_listed_with_their_size_and_deleted(qtbot, tmp_path):
    store = Originals(tmp_path / "originals")
    for name in ("first.jpg", "second.jpg"):
        (tmp_path / name).write_bytes(bytes(200_000))
        store.keep(tmp_path / name, [name.encode()])
    page = OriginalsPage(store)
    qtbot.addWidget(page)
    assert "2 originals, 0.4 MB" in page.summary.text()
    assert [page.list.item(n).text() for n in range(2)] == [
        "second.jpg  0.2 MB",
        "first.jpg  0.2 MB",
    ]
    assert not page.forget.isEnabled()
    page.list.item(0).setSelected(True)
    page.forget.click()
    assert page.list.count() == 1
    assert [one.photo.name for one in store.all()] == ["first.jpg"]
