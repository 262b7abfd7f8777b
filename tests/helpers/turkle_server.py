"""A Turkle server on loopback, run as a program: python -m tests.helpers.turkle_server FOLDER PORT.

Prints its token, then serves.

Turkle's wheel brings no settings; these are the least it runs with.
"""

import sys
from pathlib import Path

USER, PASSWORD = "worker", "a-password-for-loopback"


def configure(folder: Path) -> None:
    """Django's settings for Turkle with a database in `folder`."""
    from django.conf import settings

    settings.configure(
        SECRET_KEY="loopback only",
        DEBUG=True,
        ALLOWED_HOSTS=["127.0.0.1"],
        ROOT_URLCONF="tests.helpers.turkle_server",
        USE_TZ=True,
        TIME_ZONE="UTC",
        STATIC_URL="/static/",
        LOGIN_REDIRECT_URL="/",
        TURKLE_AUTO_ACCEPT_DEFAULT=False,
        DEFAULT_AUTO_FIELD="django.db.models.AutoField",
        DATABASES={"default": {"ENGINE": "django.db.backends.sqlite3", "NAME": str(folder / "turkle.sqlite")}},
        INSTALLED_APPS=[
            "django.contrib.admin",
            "django.contrib.auth",
            "django.contrib.contenttypes",
            "django.contrib.sessions",
            "django.contrib.messages",
            "django.contrib.staticfiles",
            "django.contrib.humanize",
            "guardian",
            "djaa_list_filter2",
            "rest_framework",
            "rest_framework.authtoken",
            "turkle",
        ],
        MIDDLEWARE=[
            "django.contrib.sessions.middleware.SessionMiddleware",
            "django.middleware.csrf.CsrfViewMiddleware",
            "django.contrib.auth.middleware.AuthenticationMiddleware",
            "django.contrib.messages.middleware.MessageMiddleware",
        ],
        AUTHENTICATION_BACKENDS=[
            "django.contrib.auth.backends.ModelBackend",
            "guardian.backends.ObjectPermissionBackend",
        ],
        TEMPLATES=[
            {
                "BACKEND": "django.template.backends.django.DjangoTemplates",
                "APP_DIRS": True,
                "OPTIONS": {
                    "context_processors": [
                        "django.template.context_processors.request",
                        "django.contrib.auth.context_processors.auth",
                        "django.contrib.messages.context_processors.messages",
                        "turkle.utils.turkle_vars",
                    ]
                },
            }
        ],
        REST_FRAMEWORK={
            "DEFAULT_AUTHENTICATION_CLASSES": ["rest_framework.authentication.TokenAuthentication"],
            "DEFAULT_PERMISSION_CLASSES": ["rest_framework.permissions.IsAdminUser"],
        },
        DATA_UPLOAD_MAX_NUMBER_FIELDS=None,
        DATA_UPLOAD_MAX_MEMORY_SIZE=None,
    )


def main(folder: Path, port: int) -> None:
    """Set up a database with a requester and a worker, and serve."""
    configure(folder)
    import django

    django.setup()
    from django.contrib.auth import get_user_model
    from django.core.management import call_command
    from rest_framework.authtoken.models import Token

    call_command("migrate", verbosity=0)
    users = get_user_model().objects
    requester = users.create_superuser("requester", password=PASSWORD)
    users.create_user(USER, password=PASSWORD)
    print(Token.objects.create(user=requester).key, flush=True)  # noqa: T201 - the test reads it
    call_command("runserver", f"127.0.0.1:{port}", use_reloader=False, verbosity=0)


def _urls() -> list[object]:
    from django.contrib import admin
    from django.contrib.staticfiles.urls import staticfiles_urlpatterns
    from django.urls import include, path

    return [
        path("admin/", admin.site.urls),
        path("api/", include("turkle.api.urls")),
        path("", include("turkle.urls")),
        path("", include("django.contrib.auth.urls")),
        *staticfiles_urlpatterns(),
    ]


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
elif "django.conf" in sys.modules and sys.modules["django.conf"].settings.configured:
    urlpatterns = _urls()
