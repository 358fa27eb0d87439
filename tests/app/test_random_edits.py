"""Many edits at random end where a fresh render does."""

from random_user import RandomUser, equals_a_fresh_render


def test_random_edits_end_where_a_fresh_render_does(opened, source):
    user = RandomUser(opened.editor, source.faces[0], seed=5)
    for number in range(36):
        user.edit()
        opened.qtbot.wait(1)
        if number % 6 == 5:
            opened.settle()
            assert equals_a_fresh_render(opened.editor), user.counts
    assert len(user.counts) >= 7, user.counts
